// SPDX-License-Identifier: LGPL-2.1-or-later
// Feeds frames of known motion to elements and looks at what comes out.
#pragma once

#include "glue/gst-raii.hpp"
#include "gsthapticmotionmeta.h"
#include "moving-texture.hpp"
#include "video-samples.hpp"

#include <chrono>
#include <functional>
#include <gst/check/gstharness.h>
#include <gst/video/video.h>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <vector>

namespace test {

struct HarnessTeardown {
  void operator()(GstHarness *harness) const { gst_harness_teardown(harness); }
};
using haptic::ElementPtr;
using haptic::MessagePtr;

inline GstVideoInfo video_info(GstVideoFormat format, int width, int height) {
  GstVideoInfo info;
  gst_video_info_set_format(&info, format, static_cast<guint>(width), static_cast<guint>(height));
  return info;
}

/// The frame in a new buffer of this format; chroma is neutral.
inline haptic::BufferPtr to_buffer(const Frame &frame, const GstVideoInfo &info) {
  haptic::BufferPtr buffer(gst_buffer_new_allocate(nullptr, GST_VIDEO_INFO_SIZE(&info), nullptr));
  gst_buffer_memset(buffer.get(), 0, 128, GST_VIDEO_INFO_SIZE(&info));
  GstVideoFrame mapped;
  gst_video_frame_map(&mapped, &info, buffer.get(), GST_MAP_WRITE);
  const guint components = GST_VIDEO_INFO_IS_RGB(&info) ? 3 : 1;
  for (guint component = 0; component < components; ++component)
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x)
        set_sample(mapped, component, x, y,
                   frame.pixels[static_cast<std::size_t>(y) * frame.width + x]);
  gst_video_frame_unmap(&mapped);
  return buffer;
}

/// Runs the action until one run took less than the second for which a report of the haptic device
/// counts: the machine may pause in between.
template <typename Action>
void within_a_second(Action &&action) {
  using Clock = std::chrono::steady_clock;
  for (bool done = false; !done;) {
    const auto begin = Clock::now();
    action();
    done = Clock::now() - begin < std::chrono::milliseconds(900);
  }
}

/// Elements between a source and a sink of the test's own.
class VideoHarness {
public:
  explicit VideoHarness(const char *line)
      : harness_(gst_harness_new_parse(line)), bus_(gst_bus_new()) {
    gst_element_set_bus(harness_->element, bus_.get());
  }
  ~VideoHarness() { gst_element_set_bus(harness_->element, nullptr); }
  VideoHarness(const VideoHarness &) = delete;
  VideoHarness &operator=(const VideoHarness &) = delete;

  void set_format(GstVideoFormat format, int width, int height) {
    info = video_info(format, width, height);
    GST_VIDEO_INFO_FPS_N(&info) = 30;
    gst_harness_set_src_caps(get(), gst_video_info_to_caps(&info));
  }

  GstFlowReturn push(haptic::BufferPtr buffer) { return gst_harness_push(get(), buffer.release()); }

  /// Pushes the frame in the format that is set and takes what comes out.
  haptic::BufferPtr pass(const Frame &frame, GstClockTime pts, guint flags = 0) {
    haptic::BufferPtr buffer = to_buffer(frame, info);
    GST_BUFFER_PTS(buffer.get()) = pts;
    GST_BUFFER_FLAG_SET(buffer.get(), flags);
    return push(std::move(buffer)) == GST_FLOW_OK ? pull() : nullptr;
  }

  haptic::BufferPtr pull() { return haptic::BufferPtr(gst_harness_try_pull(get())); }

  /// The next message of these types on the bus; nothing, if there is none.
  MessagePtr message(GstMessageType types) {
    return MessagePtr(gst_bus_pop_filtered(bus_.get(), types));
  }

  /// The next upstream event of this type that got through; nothing, if there is none.
  haptic::EventPtr upstream_event(GstEventType type) {
    while (GstEvent *event = gst_harness_try_pull_upstream_event(get())) {
      haptic::EventPtr owned(event);
      if (GST_EVENT_TYPE(event) == type)
        return owned;
    }
    return nullptr;
  }

  ElementPtr element(const char *factory) {
    return ElementPtr(gst_harness_find_element(get(), factory));
  }

  GstHarness *get() const { return harness_.get(); }

  GstVideoInfo info{};

private:
  std::unique_ptr<GstHarness, HarnessTeardown> harness_;
  haptic::BusPtr bus_;
};

/// There must be some.
inline const GstHapticMotionMeta &motion_of(const haptic::BufferPtr &buffer) {
  return *gst_buffer_get_haptic_motion_meta(buffer.get());
}

/// Metadata of the test's own, as roitracker adds them.
inline GstHapticMotionMeta &add_motion(const haptic::BufferPtr &buffer) {
  if (!gst_meta_get_info(GST_HAPTIC_MOTION_META_NAME)) { // registered with the first
    VideoHarness tracker("roitracker");
    tracker.set_format(GST_VIDEO_FORMAT_GRAY8, 64, 64);
    tracker.pass(Frame(64, 64), 0);
  }
  return *reinterpret_cast<GstHapticMotionMeta *>(
      gst_buffer_add_meta(buffer.get(), gst_meta_get_info(GST_HAPTIC_MOTION_META_NAME), nullptr));
}

/// Mean displacement of the patches, px; nothing without patches.
inline std::optional<Shift> displacement(GstBuffer *buffer) {
  const GstHapticMotionMeta *meta = gst_buffer_get_haptic_motion_meta(buffer);
  if (!meta || meta->n_patches == 0)
    return std::nullopt;
  Shift sum;
  for (guint i = 0; i < meta->n_patches; ++i) {
    sum.x += static_cast<double>(meta->patches[i].dx) / meta->n_patches;
    sum.y += static_cast<double>(meta->patches[i].dy) / meta->n_patches;
  }
  return sum;
}

/// Runs the pipeline to its end. The text of the error, or nothing.
inline std::optional<std::string> run_to_end(GstElement *pipeline,
                                             const std::function<void()> &meanwhile = {}) {
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  if (meanwhile)
    meanwhile();
  const haptic::BusPtr bus(gst_element_get_bus(pipeline));
  const MessagePtr message(
      gst_bus_timed_pop_filtered(bus.get(), 60 * GST_SECOND,
                                 static_cast<GstMessageType>(static_cast<int>(GST_MESSAGE_EOS) |
                                                             static_cast<int>(GST_MESSAGE_ERROR))));
  gst_element_set_state(pipeline, GST_STATE_NULL);
  if (!message)
    return "it did not end";
  if (GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_EOS)
    return std::nullopt;
  GError *error = nullptr;
  gst_message_parse_error(message.get(), &error, nullptr);
  std::string text = error->message;
  g_error_free(error);
  return text;
}

/// Sets each writable property that the element adds to its parents to values all over its range.
inline void flip_every_property(GstElement *element, int rounds) {
  guint count = 0;
  GParamSpec **list = g_object_class_list_properties(G_OBJECT_GET_CLASS(element), &count);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < rounds; ++round)
    for (guint i = 0; i < count; ++i) {
      GParamSpec *spec = list[i];
      if (spec->owner_type != G_OBJECT_TYPE(element))
        continue;
      GValue value = G_VALUE_INIT;
      if (spec->flags & G_PARAM_WRITABLE) {
        g_value_init(&value, spec->value_type);
        if (auto *number = G_IS_PARAM_SPEC_UINT(spec) ? G_PARAM_SPEC_UINT(spec) : nullptr)
          g_value_set_uint(
              &value, number->minimum +
                          static_cast<guint>(unit(random) * (number->maximum - number->minimum)));
        else if (auto *real = G_IS_PARAM_SPEC_DOUBLE(spec) ? G_PARAM_SPEC_DOUBLE(spec) : nullptr)
          g_value_set_double(&value,
                             real->minimum + unit(random) * (real->maximum - real->minimum));
        else if (auto *choice = G_IS_PARAM_SPEC_ENUM(spec) ? G_PARAM_SPEC_ENUM(spec) : nullptr)
          g_value_set_enum(
              &value, choice->enum_class->values[random() % choice->enum_class->n_values].value);
        else if (G_IS_PARAM_SPEC_BOOLEAN(spec))
          g_value_set_boolean(&value, random() % 2 == 0);
        g_object_set_property(G_OBJECT(element), spec->name, &value);
        g_value_unset(&value);
      }
      if (spec->flags & G_PARAM_READABLE) {
        g_object_get_property(G_OBJECT(element), spec->name, &value);
        g_value_unset(&value);
      }
    }
  g_free(list);
}

/// Starts and stops a pipeline so many times, through each of the states in between.
inline void start_and_stop(GstElement *pipeline, int times) {
  for (int i = 0; i < times; ++i) {
    gst_element_set_state(pipeline, i % 2 ? GST_STATE_PLAYING : GST_STATE_PAUSED);
    ASSERT_EQ(gst_element_get_state(pipeline, nullptr, nullptr, GST_CLOCK_TIME_NONE),
              GST_STATE_CHANGE_SUCCESS);
    ASSERT_EQ(gst_element_set_state(pipeline, i % 3 ? GST_STATE_NULL : GST_STATE_READY),
              GST_STATE_CHANGE_SUCCESS);
  }
  gst_element_set_state(pipeline, GST_STATE_NULL);
}

} // namespace test
