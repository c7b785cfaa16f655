// SPDX-License-Identifier: LGPL-2.1-or-later
// velocityavg turns the metadata that roitracker attached to a frame into one motion sample
// (paper, equations 2 and 3). It does not read the pixels.
//
//   gst-launch-1.0 videotestsrc pattern=ball ! roitracker ! velocityavg ! hapticsink
//
// A frame without a measurement gives a sample with the GAP flag, so that the branch never starves.
#include "elements/average-types.hpp"
#include "elements/motion-reader.hpp"
#include "frames/frame-caps.hpp"
#include "frames/luma-crop.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/property-table.hpp"
#include "glue/stream-lock.hpp"
#include "gsthapticmotionmeta.h"
#include "messages.hpp"

#include <gst/base/gstbasetransform.h>
#include <gst/video/gstvideometa.h>
#include <span>
#include <utility>

G_DECLARE_FINAL_TYPE(GstVelocityAvg, gst_velocity_avg, GST, VELOCITY_AVG, GstBaseTransform)

GST_DEBUG_CATEGORY_STATIC(velocityavg_debug);
#define GST_CAT_DEFAULT velocityavg_debug

namespace {

using haptic::Average;
using haptic::kGuarded;
using haptic::ModelChoice;
using haptic::MotionSample;

// State

struct Settings {
  Average average = haptic::kUsualAverage;
  ModelChoice motion_model = ModelChoice::automatic;
  bool post_messages = false;
};

struct State {
  // Object lock: written by the application, read by the streaming thread.
  Settings settings;

  // Streaming thread only, or while it is stopped.
  GstVideoInfo frame; // of the caps
  haptic::MotionReader reader;
  bool warned_of_metadata = false;
};

} // namespace

struct _GstVelocityAvg {
  GstBaseTransform parent;
  State *state; // made in _init, deleted in _finalize
};

G_DEFINE_TYPE_WITH_CODE(GstVelocityAvg, gst_velocity_avg, GST_TYPE_BASE_TRANSFORM,
                        GST_DEBUG_CATEGORY_INIT(velocityavg_debug, "velocityavg", 0,
                                                "one velocity per frame"))
GST_ELEMENT_REGISTER_DEFINE(velocityavg, "velocityavg", GST_RANK_NONE, gst_velocity_avg_get_type())

namespace {

// Properties

std::span<const haptic::Property<Settings>> properties() {
  using Rows = haptic::Rows<Settings>;
  static const haptic::Property<Settings> table[] = {
      Rows::choice<&Settings::average>("average", "Average",
                                       "How the velocities of the points become one",
                                       haptic::average_type()),
      Rows::choice<&Settings::motion_model>(
          "motion-model", "Motion Model",
          "Motion model that is fitted with average=pointed and model",
          haptic::motion_model_type()),
      Rows::flag<&Settings::post_messages>("post-messages", "Post Messages",
                                           "Post an element message haptic-motion for each frame"),
  };
  return table;
}

// Streaming

void warn_of_metadata(GstVelocityAvg *self) {
  if (std::exchange(self->state->warned_of_metadata, true))
    return;
  GST_ELEMENT_WARNING(self, STREAM, WRONG_TYPE, (haptic::messages::kNoMetadata),
                      ("no GstHapticMotionMeta: there is no roitracker, or an element after it "
                       "dropped the metadata (cropping, composing and encoding do)"));
}

void post(GstVelocityAvg *self, GstClockTime pts, const MotionSample &sample) {
  GstStructure *fields = gst_structure_new("haptic-motion", "pts", G_TYPE_UINT64, pts, nullptr);
  haptic::set_motion(fields, sample);
  gst_element_post_message(GST_ELEMENT(self), gst_message_new_element(GST_OBJECT(self), fields));
}

GstFlowReturn transform(GstVelocityAvg *self, GstBuffer *frame, GstBuffer *out) {
  State &state = *self->state;
  const Settings settings = haptic::locked_copy(self, state.settings);
  MotionSample sample;
  if (const GstHapticMotionMeta *meta = gst_buffer_get_haptic_motion_meta(frame)) {
    sample = state.reader.read(*meta, state.frame, settings.average, settings.motion_model);
  } else {
    warn_of_metadata(self);
    sample = state.reader.read_nothing(state.frame);
  }

  const haptic::MotionSampleBytes bytes = haptic::pack_motion_sample(sample);
  gst_buffer_fill(out, 0, bytes.data(), bytes.size());
  gst_buffer_set_size(out, static_cast<gssize>(bytes.size()));
  if (!(sample.confidence > 0))
    GST_BUFFER_FLAG_SET(out, GST_BUFFER_FLAG_GAP);
  GST_LOG_OBJECT(self, "%.2f, %.2f px/s, confidence %.2f, %u points", sample.velocity_x,
                 sample.velocity_y, sample.confidence, sample.points);
  if (settings.post_messages)
    post(self, GST_BUFFER_PTS(frame), sample);
  return GST_FLOW_OK;
}

gboolean set_caps(GstVelocityAvg *self, GstCaps *in) {
  return gst_video_info_from_caps(&self->state->frame, in);
}

GstFlowReturn prepare_output_buffer(GstVelocityAvg *, GstBuffer *in, GstBuffer **out) {
  *out = gst_buffer_new_allocate(nullptr, haptic::kHeldMotionSampleSize, nullptr);
  haptic::copy_timing(in, *out);
  return GST_FLOW_OK;
}

gboolean stop(GstVelocityAvg *self) {
  const haptic::StreamLock stream(self);
  self->state->reader = {};
  self->state->warned_of_metadata = false;
  return TRUE;
}

} // namespace

static void gst_velocity_avg_class_init(GstVelocityAvgClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  haptic::describe(
      element_class, "velocityavg", "Velocity averager", "Filter/Analyzer/Video",
      "Turns the motion that roitracker found in a frame into one haptic motion sample",
      GST_VIDEO_CAPS_MAKE(HAPTIC_VIDEO_FORMATS), HAPTIC_MOTION_CAPS);

  auto *object_class = G_OBJECT_CLASS(klass);
  object_class->finalize = haptic::delete_state<GstVelocityAvg, gst_velocity_avg_parent_class>;
  haptic::install_properties<properties>(object_class, [](GObject *object) -> Settings & {
    return GST_VELOCITY_AVG(object)->state->settings;
  });

  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);
  transform_class->transform_caps = kGuarded<haptic::transform_frame_caps>;
  transform_class->set_caps = kGuarded<set_caps>;
  transform_class->prepare_output_buffer = kGuarded<prepare_output_buffer>;
  transform_class->transform = kGuarded<transform>;
  transform_class->propose_allocation = kGuarded<haptic::accept_any_strides>;
  transform_class->stop = kGuarded<stop>;
}

static void gst_velocity_avg_init(GstVelocityAvg *self) {
  self->state = new State;
  gst_video_info_init(&self->state->frame);
  haptic::keep_every_frame(GST_BASE_TRANSFORM(self));
}
