// SPDX-License-Identifier: LGPL-2.1-or-later
// Feeds samples or bytes into a pipeline and takes what comes out at its end.
#pragma once

#include "glue/gst-raii.hpp"
#include "samples/motion-sample.hpp"

#include <filesystem>
#include <fstream>
#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <gtest/gtest.h>
#include <iterator>
#include <optional>
#include <string>
#include <unistd.h>
#include <vector>

namespace test {

using Bytes = std::vector<std::uint8_t>;

struct Packet {
  Bytes bytes;
  GstClockTime pts = GST_CLOCK_TIME_NONE;
  GstClockTime duration = GST_CLOCK_TIME_NONE;
  guint flags = 0;
};

inline Packet packet_of(const haptic::MotionSample &sample, GstClockTime pts,
                        GstClockTime duration) {
  const auto bytes = haptic::pack_motion_sample(sample);
  return {Bytes(bytes.begin(), bytes.end()), pts, duration,
          sample.confidence > 0 ? 0U : static_cast<guint>(GST_BUFFER_FLAG_GAP)};
}

inline Packet packet_of_buffer(GstBuffer *buffer) {
  Packet packet{Bytes(gst_buffer_get_size(buffer)), GST_BUFFER_PTS(buffer),
                GST_BUFFER_DURATION(buffer), GST_BUFFER_FLAGS(buffer)};
  gst_buffer_extract(buffer, 0, packet.bytes.data(), packet.bytes.size());
  return packet;
}

inline haptic::MotionSample sample_of(const Packet &packet) {
  const auto sample = haptic::unpack_motion_sample(packet.bytes);
  EXPECT_TRUE(sample.has_value());
  return sample.value_or(haptic::MotionSample{});
}

struct Outcome {
  std::vector<Packet> packets; ///< at the appsink `out`
  std::vector<std::string> warnings;
  std::string error;
};

inline void push(GstAppSrc *in, const Packet &packet) {
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, packet.bytes.size(), nullptr);
  gst_buffer_fill(buffer, 0, packet.bytes.data(), packet.bytes.size());
  GST_BUFFER_PTS(buffer) = packet.pts;
  GST_BUFFER_DURATION(buffer) = packet.duration;
  GST_BUFFER_FLAG_SET(buffer, packet.flags);
  gst_app_src_push_buffer(in, buffer);
}

class Pipeline {
public:
  explicit Pipeline(const std::string &line) {
    GError *error = nullptr;
    pipeline_ = gst_parse_launch(line.c_str(), &error);
    EXPECT_EQ(error, nullptr) << error->message;
    g_clear_error(&error);
  }
  ~Pipeline() {
    gst_element_set_state(pipeline_, GST_STATE_NULL);
    gst_object_unref(pipeline_);
  }
  Pipeline(const Pipeline &) = delete;
  Pipeline &operator=(const Pipeline &) = delete;

  /// Pushes all of it into the appsrc `in`, and waits for the end or an error.
  Outcome run(const std::vector<Packet> &input = {}) {
    Outcome outcome;
    gst_element_set_state(pipeline_, GST_STATE_PLAYING);
    if (GstElement *in = gst_bin_get_by_name(GST_BIN(pipeline_), "in")) {
      for (const auto &packet : input)
        push(GST_APP_SRC(in), packet);
      gst_app_src_end_of_stream(GST_APP_SRC(in));
      gst_object_unref(in);
    }
    if (GstElement *out = gst_bin_get_by_name(GST_BIN(pipeline_), "out")) {
      while (!gst_app_sink_is_eos(GST_APP_SINK(out)) && !over_) {
        GstSample *sample = gst_app_sink_try_pull_sample(GST_APP_SINK(out), 50 * GST_MSECOND);
        look_at_messages(outcome, 0);
        if (!sample)
          continue;
        outcome.packets.push_back(packet_of_buffer(gst_sample_get_buffer(sample)));
        gst_sample_unref(sample);
      }
      gst_object_unref(out);
    }
    wait(outcome);
    return outcome;
  }

  GstElement *get() const { return pipeline_; }

private:
  void wait(Outcome &outcome) {
    look_at_messages(outcome, 60 * GST_SECOND);
    if (!over_)
      outcome.error = "it does not end";
  }

  // Until the end, or until none has come for so long.
  void look_at_messages(Outcome &outcome, GstClockTime patience) {
    GstBus *bus = gst_element_get_bus(pipeline_);
    while (GstMessage *message = over_ ? nullptr : gst_bus_timed_pop(bus, patience)) {
      GError *error = nullptr;
      switch (GST_MESSAGE_TYPE(message)) {
      case GST_MESSAGE_EOS:
        over_ = true;
        break;
      case GST_MESSAGE_ERROR:
        over_ = true;
        gst_message_parse_error(message, &error, nullptr);
        outcome.error = error->message;
        break;
      case GST_MESSAGE_WARNING:
        gst_message_parse_warning(message, &error, nullptr);
        outcome.warnings.emplace_back(error->message);
        break;
      default:
        break;
      }
      g_clear_error(&error);
      gst_message_unref(message);
    }
    gst_object_unref(bus);
  }

  GstElement *pipeline_ = nullptr;
  bool over_ = false;
};

inline Outcome run(const std::string &line, const std::vector<Packet> &input = {}) {
  return Pipeline(line).run(input);
}

/// A folder that goes away.
class ScratchFolder {
public:
  ScratchFolder()
      : path_(std::filesystem::temp_directory_path() / ("track-test-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  ScratchFolder(const ScratchFolder &) = delete;
  ScratchFolder &operator=(const ScratchFolder &) = delete;

  std::string file(const std::string &name) const { return (path_ / name).string(); }

private:
  std::filesystem::path path_;
};

inline Bytes read_file(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  return Bytes{std::istreambuf_iterator<char>(file), {}};
}

inline void write_file(const std::string &path, std::span<const std::uint8_t> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char *>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

inline bool has_elements(std::initializer_list<const char *> names) {
  for (const char *name : names) {
    GstElementFactory *factory = gst_element_factory_find(name);
    if (!factory)
      return false;
    gst_object_unref(factory);
  }
  return true;
}

} // namespace test
