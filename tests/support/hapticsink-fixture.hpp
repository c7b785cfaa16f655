// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticsink in a small pipeline, with the simulated device; what it did is read from its log.
#pragma once

#include "eventually.hpp"
#include "glue/gst-raii.hpp"
#include "glue/pointer-event.hpp"
#include "samples/motion-sample.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gst/app/gstappsrc.h>
#include <gst/check/gstharness.h>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <span>
#include <sstream>
#include <thread>
#include <vector>

namespace test {

using namespace std::chrono_literals;
using haptic::MotionSample;

struct ObjectDeleter {
  void operator()(gpointer object) const { gst_object_unref(object); }
};
struct HarnessDeleter {
  void operator()(GstHarness *harness) const { gst_harness_teardown(harness); }
};
struct MessageDeleter {
  void operator()(GstMessage *message) const { gst_message_unref(message); }
};
using ElementPtr = std::unique_ptr<GstElement, ObjectDeleter>;
using HarnessPtr = std::unique_ptr<GstHarness, HarnessDeleter>;
using MessagePtr = std::unique_ptr<GstMessage, MessageDeleter>;

constexpr GstClockTime kFrame = GST_SECOND / 30;
constexpr const char *kCaps = HAPTIC_MOTION_CAPS ", width=352, height=288, framerate=30/1";

inline MotionSample moving(double vx, double vy) {
  MotionSample sample;
  sample.velocity_x = static_cast<float>(vx);
  sample.velocity_y = static_cast<float>(vy);
  sample.confidence = 1;
  sample.interval = kFrame;
  sample.frame_width = 352;
  sample.frame_height = 288;
  sample.points = 20;
  sample.model = haptic::MotionModel::translation;
  return sample;
}

inline GstBuffer *packed(std::span<const std::uint8_t> bytes, GstClockTime pts) {
  GstBuffer *buffer = gst_buffer_new_memdup(bytes.data(), bytes.size());
  GST_BUFFER_PTS(buffer) = pts;
  GST_BUFFER_DURATION(buffer) = kFrame;
  return buffer;
}

inline GstBuffer *packed(const MotionSample &sample, GstClockTime pts) {
  return packed(haptic::pack_motion_sample(sample), pts);
}

inline GstBuffer *gap(GstClockTime pts) {
  GstBuffer *buffer = packed({.frame_width = 352, .frame_height = 288}, pts);
  GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_GAP);
  return buffer;
}

/// The paper's equation 5 with the element's defaults, N.
inline double equation5(double v) {
  return 2 / std::numbers::pi * std::atan(0.01 * v);
}

struct Row {
  double time, x, y, z, vx, vy, spin, fx, fy, fz, tx, ty, tz, confidence, t[8], mono, hold;
  double q[4], energy, w[3], realised_force[3], realised_torque[3];
  double proxy[3], touch, limits;
  double force() const { return std::hypot(fx, fy, fz); }
  /// Whether the force was held for one of these reasons (docs/formats/csv-log.md).
  bool held(unsigned reasons) const { return (static_cast<unsigned>(hold) & reasons) != 0; }
};

inline Row parse_row(const std::string &line) {
  std::istringstream fields(line);
  std::array<double, 43> values{};
  std::size_t n = 0;
  for (std::string field; std::getline(fields, field, ',') && n < values.size(); ++n)
    values[n] = std::stod(field);
  EXPECT_EQ(n, values.size()) << line;
  Row row;
  static_assert(sizeof row == sizeof values);
  std::memcpy(&row, values.data(), sizeof row);
  return row;
}

inline std::vector<Row> read_log(const std::filesystem::path &path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line,
            "time,x,y,z,vx,vy,spin,fx,fy,fz,tx,ty,tz,confidence,t0,t1,t2,t3,t4,t5,t6,t7,mono,hold"
            ",qx,qy,qz,qw,energy,wx,wy,wz,rfx,rfy,rfz,rtx,rty,rtz,px,py,pz,touch,limits");
  std::vector<Row> rows;
  while (std::getline(file, line))
    rows.push_back(parse_row(line));
  return rows;
}

/// Bits of the column `hold` (docs/formats/csv-log.md).
constexpr unsigned kHeldPaused = 1 << 1;
constexpr unsigned kHeldFlushing = 1 << 2;
constexpr unsigned kHeldEnded = 1 << 3;
constexpr unsigned kHeldReleased = 1 << 4;
constexpr unsigned kHeldGap = 1 << 9;
constexpr unsigned kHeldStale = 1 << 10;

/// The rows for which the force was not held, nor in the 0.3 s before them: neither a test's event
/// nor a delay of the machine (kHoldLate, kHoldStale) shows in them.
inline std::vector<Row> undisturbed(const std::vector<Row> &rows) {
  std::vector<Row> quiet;
  double held_at = 0; // s, mono
  for (const Row &row : rows) {
    if (row.hold != 0)
      held_at = row.mono;
    else if (row.mono - held_at > 0.3)
      quiet.push_back(row);
  }
  return quiet;
}

/// The first row at this running time (s) or later.
inline Row row_at(const std::vector<Row> &rows, double time) {
  for (const Row &row : rows)
    if (row.time >= time)
      return row;
  ADD_FAILURE() << "no row at " << time << " s";
  return {};
}

/// The last row in which the force was not held.
inline Row last_free_row(const std::vector<Row> &rows) {
  for (auto row = rows.rbegin(); row != rows.rend(); ++row)
    if (row->hold == 0)
      return *row;
  ADD_FAILURE() << "the force was always held";
  return {};
}

/// From the first row held for this reason on the force falls in a straight line to zero in
/// `seconds`, whenever the ticks came, and stays there until it is no longer held.
inline void expect_fade(const std::vector<Row> &rows, unsigned reason, double seconds) {
  const auto first = std::ranges::find_if(rows, [&](const Row &row) { return row.held(reason); });
  ASSERT_NE(first, rows.end());
  ASSERT_NE(first, rows.begin());
  const Row full = *std::prev(first);
  ASSERT_GT(full.force(), 0.1);
  const auto end = std::find_if(first, rows.end(), [](const Row &row) { return row.hold == 0; });
  EXPECT_EQ(std::prev(end)->force(), 0);
  for (auto row = first; row != end; ++row) {
    const double line = std::max(0.0, 1 - (row->mono - full.mono) / seconds);
    ASSERT_LE(row->force(), full.force() * line + 1e-6) << row->mono - full.mono << " s";
    if ((static_cast<unsigned>(row->hold) & ~reason) == 0) { // else another fade is faster
      ASSERT_GE(row->force(), full.force() * line - 0.011) << row->mono - full.mono << " s";
    }
  }
}

/// Finite and within `most`. A force that is held only falls, and one that is not held changes no
/// faster than the slew rate allows in the time between the two rows.
inline void expect_sound(const std::vector<Row> &rows, double most = 1) {
  ASSERT_GT(rows.size(), 100U);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Row &before = rows[i - 1];
    const Row &now = rows[i];
    ASSERT_TRUE(std::isfinite(now.force()));
    ASSERT_LE(now.force(), most + 1e-6);
    ASSERT_GT(now.mono, before.mono);
    const double step = std::hypot(now.fx - before.fx, now.fy - before.fy, now.fz - before.fz);
    if (now.hold != 0) {
      ASSERT_LE(now.force(), before.force() + 1e-8) << "at " << now.mono << " s";
    } else {
      ASSERT_LE(step, 20 * (now.mono - before.mono) + 1e-6) << "at " << now.mono << " s";
    }
  }
}

/// Runs a function at the end of a scope, also after a failed assertion.
class AtEnd {
public:
  explicit AtEnd(std::function<void()> call) : call_(std::move(call)) {}
  ~AtEnd() { call_(); }
  AtEnd(const AtEnd &) = delete;
  AtEnd &operator=(const AtEnd &) = delete;

private:
  std::function<void()> call_;
};

class HapticSink : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "hapticsink-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    directory_ = name;
    log_ = directory_ / "log.csv";
  }
  void TearDown() override {
    if (pipeline_)
      stop();
    pipeline_.reset();
    std::filesystem::remove_all(directory_);
  }

  void build(const std::string &properties, const std::string &source = "") {
    const std::string line = "appsrc name=source format=time caps=\"" + std::string(kCaps) + "\" " +
                             source + " ! hapticsink name=sink fault-location=none " + properties;
    GError *error = nullptr;
    pipeline_.reset(gst_parse_launch(line.c_str(), &error));
    ASSERT_EQ(error, nullptr) << error->message;
    source_.reset(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "source"));
    sink_.reset(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "sink"));
    set_clock(pipeline_.get());
  }
  void build_logging(const std::string &properties = "") {
    build("device=sim log-location=" + log_.string() + " " + properties);
  }

  // Time is that of the machine, unless a derived fixture has another clock (VirtualSink).

  virtual void set_clock(GstElement * /*pipeline*/) {}
  virtual void advance(std::chrono::nanoseconds duration) { std::this_thread::sleep_for(duration); }
  virtual bool advance_until(const std::function<bool()> &condition) {
    return eventually(condition);
  }
  /// Makes a call that may have to wait until time has passed.
  virtual void complete(const std::function<void()> &call) { call(); }

  GstStateChangeReturn change(GstElement *element, GstState state) {
    GstStateChangeReturn result = GST_STATE_CHANGE_FAILURE;
    complete([&] { result = gst_element_set_state(element, state); });
    return result;
  }
  void set(GstState state) { ASSERT_NE(change(pipeline_.get(), state), GST_STATE_CHANGE_FAILURE); }
  /// Waits until a change of the state is complete.
  void wait_for_change() {
    GstStateChangeReturn result = GST_STATE_CHANGE_ASYNC;
    EXPECT_TRUE(advance_until([&] {
      result = gst_element_get_state(pipeline_.get(), nullptr, nullptr, 0);
      return result != GST_STATE_CHANGE_ASYNC;
    }));
    ASSERT_EQ(result, GST_STATE_CHANGE_SUCCESS);
  }
  void wait_for(GstState state) {
    set(state);
    wait_for_change();
  }
  void stop() { change(pipeline_.get(), GST_STATE_NULL); }

  void push(GstBuffer *buffer) {
    ASSERT_EQ(gst_app_src_push_buffer(GST_APP_SRC(source_.get()), buffer), GST_FLOW_OK);
  }
  /// One sample per frame; they wait in the source for their time.
  void push_motion(double vx, double vy, double seconds) {
    for (int n = static_cast<int>(seconds * 30); n > 0; --n, pts_ += kFrame)
      push(packed(moving(vx, vy), pts_));
  }
  void push_end() { gst_app_src_end_of_stream(GST_APP_SRC(source_.get())); }

  /// Without waiting for one, null if there is none yet.
  MessagePtr message(GstMessageType types, bool wait = true) {
    GstBus *bus = gst_element_get_bus(pipeline_.get());
    MessagePtr found;
    const auto pop = [&] {
      found.reset(gst_bus_pop_filtered(bus, types));
      return found != nullptr;
    };
    if (wait)
      advance_until(pop);
    else
      pop();
    gst_object_unref(bus);
    return found;
  }
  void wait_for_end() {
    const auto found = message(static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
    ASSERT_TRUE(found);
    ASSERT_EQ(GST_MESSAGE_TYPE(found.get()), GST_MESSAGE_EOS);
  }

  void play_to_end() {
    push_end();
    set(GST_STATE_PLAYING);
    wait_for_end();
  }

  /// What a film of half a second with this speed has posted of its statistics at its end.
  haptic::StructurePtr statistics_of_film(double vx) {
    push_motion(vx, 0, 0.5);
    push_end();
    set(GST_STATE_PLAYING);
    auto posted = posted_until_end("hapticsink-stats");
    EXPECT_EQ(posted.size(), 1U);
    return posted.empty() ? nullptr : std::move(posted.front());
  }

  /// What the element messages of this name contain until the end.
  std::vector<haptic::StructurePtr> posted_until_end(const char *name) {
    std::vector<haptic::StructurePtr> posted;
    for (;;) {
      const auto found =
          message(static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ELEMENT));
      EXPECT_TRUE(found);
      if (!found || GST_MESSAGE_TYPE(found.get()) == GST_MESSAGE_EOS)
        return posted;
      if (gst_message_has_name(found.get(), name))
        posted.emplace_back(gst_structure_copy(gst_message_get_structure(found.get())));
    }
  }

  std::vector<Row> stop_and_read_log() {
    stop();
    return read_log(log_);
  }
  std::vector<Row> play_and_read_log() {
    play_to_end();
    return stop_and_read_log();
  }

  /// A flush that ends when the force is zero.
  void flush() {
    const haptic::PadPtr pad(gst_element_get_static_pad(sink_.get(), "sink"));
    complete([&] { gst_pad_send_event(pad.get(), gst_event_new_flush_start()); });
    EXPECT_TRUE(advance_until([&] { return newest_row()->force() == 0; }));
    complete([&] { gst_pad_send_event(pad.get(), gst_event_new_flush_stop(FALSE)); });
  }

  /// Null: none.
  void set_sync_handler(GstBusSyncHandler handler, gpointer data = nullptr) {
    GstBus *bus = gst_element_get_bus(pipeline_.get());
    gst_bus_set_sync_handler(bus, handler, data, nullptr);
    gst_object_unref(bus);
  }

  /// The newest complete row of the log, which is being written.
  std::optional<Row> newest_row() const {
    std::ifstream file(log_);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto end = text.rfind('\n');
    const auto begin = end == std::string::npos || end == 0 ? end : text.rfind('\n', end - 1);
    if (begin == std::string::npos)
      return std::nullopt;
    return parse_row(text.substr(begin + 1, end - begin - 1));
  }

  bool armed() const {
    gboolean armed = FALSE;
    g_object_get(sink_.get(), "armed", &armed, nullptr);
    return armed;
  }
  haptic::StructurePtr stats() const {
    GstStructure *stats = nullptr;
    g_object_get(sink_.get(), "stats", &stats, nullptr);
    return haptic::StructurePtr(stats);
  }
  guint64 count(const char *name) const {
    guint64 value = 0;
    EXPECT_TRUE(gst_structure_get_uint64(stats().get(), name, &value)) << name;
    return value;
  }
  double number(const char *name) const {
    double value = 0;
    EXPECT_TRUE(gst_structure_get_double(stats().get(), name, &value)) << name;
    return value;
  }

  std::filesystem::path directory_;
  std::filesystem::path log_;
  ElementPtr pipeline_;
  ElementPtr source_;
  ElementPtr sink_;
  GstClockTime pts_ = 0;
};

} // namespace test
