// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticsink, linked by the test, in a pipeline whose time passes when the test says so.
#pragma once

#include "elements/sink-clock.hpp"
#include "hapticsink-fixture.hpp"
#include "virtual-clock.hpp"

#include <cstdlib>
#include <gst/check/gsttestclock.h>
#include <sstream>
#include <string>

namespace test {

/// Its time is that of a clock of GStreamer, too.
class PipelineClock final : public VirtualClock {
public:
  GstClock *gst() const { return GST_CLOCK(clock_.get()); }
  /// Until when the first element waits, or nothing if none does.
  std::optional<GstClockTime> next_of_gstreamer() const {
    GstClockID id = nullptr;
    if (!gst_test_clock_peek_next_pending_id(clock_.get(), &id))
      return std::nullopt;
    const GstClockTime due = gst_clock_id_get_time(id);
    gst_clock_id_unref(id);
    return due;
  }

private:
  std::optional<std::int64_t> others_due() override {
    const auto due = next_of_gstreamer();
    return due ? std::optional(static_cast<std::int64_t>(*due)) : std::nullopt;
  }
  void wake_other() override {
    if (GstClockID id = gst_test_clock_process_next_clock_id(clock_.get()))
      gst_clock_id_unref(id);
  }
  void pass_to(std::int64_t now) override {
    VirtualClock::pass_to(now);
    gst_test_clock_set_time(clock_.get(), static_cast<GstClockTime>(this->now()));
  }

  std::unique_ptr<GstTestClock, ObjectDeleter> clock_{
      GST_TEST_CLOCK(gst_test_clock_new_with_start_time(static_cast<GstClockTime>(now())))};
};

class VirtualSink : public HapticSink {
protected:
  /// Without a registry, in which hapticsink would be the plugin's. PLUGINS lists what the tests
  /// need besides.
  static void SetUpTestSuite() {
    HapticSink::SetUpTestSuite();
    GST_ELEMENT_REGISTER(hapticsink, nullptr);
    const char *listed = std::getenv("PLUGINS");
    std::istringstream plugins(listed ? listed : "");
    for (std::string path; std::getline(plugins, path, ':');) {
      GError *error = nullptr;
      GstPlugin *plugin = gst_plugin_load_file(path.c_str(), &error);
      ASSERT_NE(plugin, nullptr) << error->message;
      gst_object_unref(plugin);
    }
  }

  void set_clock(GstElement *pipeline) override {
    gst_pipeline_use_clock(GST_PIPELINE(pipeline), clock_.gst());
    const ElementPtr sink(gst_bin_get_by_name(GST_BIN(pipeline), "sink"));
    if (sink)
      haptic::set_clock(GST_HAPTIC_SINK(sink.get()), clock_);
  }
  void advance(std::chrono::nanoseconds duration) override { clock_.advance(duration); }
  bool advance_until(const std::function<bool()> &condition) override {
    return clock_.advance_until(condition);
  }
  void complete(const std::function<void()> &call) override { clock_.run(call); }

  PipelineClock clock_;
};

} // namespace test
