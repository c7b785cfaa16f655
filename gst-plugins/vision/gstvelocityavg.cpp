// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstvelocityavg.h"

#include "exception-barrier.hpp"
#include "frame-caps.hpp"
#include "gst-raii.hpp"
#include "gsthapticmotionmeta.h"
#include "luma-crop.hpp"
#include "motion-reader.hpp"

#include <gst/video/gstvideometa.h>
#include <string>

GST_DEBUG_CATEGORY_STATIC(velocityavg_debug);
#define GST_CAT_DEFAULT velocityavg_debug

namespace {

using haptic::Average;
using haptic::guarded;
using haptic::ModelChoice;
using haptic::MotionSample;
using haptic::ObjectLock;

enum PropertyId : guint { kAverage = 1, kMotionModel, kPostMessages };

struct Settings {
  Average average = Average::model;
  ModelChoice motion_model = ModelChoice::automatic;
  bool post_messages = false;
};

struct State {
  // Object lock: written by the application, read by the streaming thread.
  Settings settings;

  // Streaming thread only, or while it is stopped.
  GstVideoInfo frame; // of the caps
  haptic::MotionReader reader;
  bool told_about_metadata = false;
};

} // namespace

struct _GstVelocityAvg {
  GstBaseTransform parent;
  State *state; // made in _init, deleted in _finalize
};

static GstStaticPadTemplate sink_template =
    GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                            GST_STATIC_CAPS(GST_VIDEO_CAPS_MAKE(HAPTIC_VIDEO_FORMATS)));
static GstStaticPadTemplate src_template = GST_STATIC_PAD_TEMPLATE(
    "src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(HAPTIC_MOTION_CAPS));

G_DEFINE_TYPE_WITH_CODE(GstVelocityAvg, gst_velocity_avg, GST_TYPE_BASE_TRANSFORM,
                        GST_DEBUG_CATEGORY_INIT(velocityavg_debug, "velocityavg", 0,
                                                "one velocity per frame"))
GST_ELEMENT_REGISTER_DEFINE(velocityavg, "velocityavg", GST_RANK_NONE, GST_TYPE_VELOCITY_AVG)

namespace {

GType average_type() {
  static const GEnumValue values[] = {
      {static_cast<int>(Average::model), "A motion model fitted to the points, at the pointer",
       "model"},
      {static_cast<int>(Average::mean), "The mean of the points' velocities", "mean"},
      {static_cast<int>(Average::median), "The median of each component", "median"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstVelocityAvgAverage", values);
  return type;
}

GType motion_model_type() {
  static const GEnumValue values[] = {
      {static_cast<int>(ModelChoice::automatic), "The smallest that explains the points", "auto"},
      {static_cast<int>(ModelChoice::still), "Nothing moves", "static"},
      {static_cast<int>(ModelChoice::translation), "All points move alike", "translation"},
      {static_cast<int>(ModelChoice::similarity), "Points also turn and grow about the pointer",
       "similarity"},
      {static_cast<int>(ModelChoice::affine), "Points also shear and stretch", "affine"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstVelocityAvgMotionModel", values);
  return type;
}

void tell_once_about_metadata(GstVelocityAvg *self) {
  if (std::exchange(self->state->told_about_metadata, true))
    return;
  GST_ELEMENT_WARNING(self, STREAM, WRONG_TYPE,
                      ("The frames carry no motion. Put roitracker directly before velocityavg."),
                      ("no GstHapticMotionMeta: there is no roitracker, or an element after it "
                       "dropped the metadata (cropping, composing and encoding do)"));
}

void post(GstVelocityAvg *self, GstClockTime pts, const MotionSample &sample) {
  const std::string model(haptic::motion_model_name(sample.model));
  GstStructure *fields = gst_structure_new(
      "haptic-motion", "pts", G_TYPE_UINT64, pts, "interval", G_TYPE_UINT64, sample.interval, "vx",
      G_TYPE_DOUBLE, static_cast<double>(sample.velocity_x), "vy", G_TYPE_DOUBLE,
      static_cast<double>(sample.velocity_y), "spin", G_TYPE_DOUBLE,
      static_cast<double>(sample.spin), "divergence", G_TYPE_DOUBLE,
      static_cast<double>(sample.divergence), "confidence", G_TYPE_DOUBLE,
      static_cast<double>(sample.confidence), "points", G_TYPE_UINT,
      static_cast<guint>(sample.points), "model", G_TYPE_STRING, model.c_str(), nullptr);
  gst_element_post_message(GST_ELEMENT(self), gst_message_new_element(GST_OBJECT(self), fields));
}

GstFlowReturn process(GstVelocityAvg *self, GstBuffer *frame, GstBuffer *out) {
  State &state = *self->state;
  Settings settings;
  {
    const ObjectLock lock(self);
    settings = state.settings;
  }
  MotionSample sample;
  if (const GstHapticMotionMeta *meta = gst_buffer_get_haptic_motion_meta(frame)) {
    sample = state.reader.read(*meta, state.frame, settings.average, settings.motion_model);
  } else {
    tell_once_about_metadata(self);
    sample = state.reader.read_nothing(state.frame);
  }

  const haptic::MotionSampleBytes bytes = haptic::pack_motion_sample(sample);
  gst_buffer_fill(out, 0, bytes.data(), bytes.size());
  if (!(sample.confidence > 0))
    GST_BUFFER_FLAG_SET(out, GST_BUFFER_FLAG_GAP);
  GST_LOG_OBJECT(self, "%.2f, %.2f px/s, confidence %.2f, %u points", sample.velocity_x,
                 sample.velocity_y, sample.confidence, sample.points);
  if (settings.post_messages)
    post(self, GST_BUFFER_PTS(frame), sample);
  return GST_FLOW_OK;
}

} // namespace

static GstCaps *gst_velocity_avg_transform_caps(GstBaseTransform *trans, GstPadDirection direction,
                                                GstCaps *caps, GstCaps *filter) {
  return guarded(trans, static_cast<GstCaps *>(nullptr), [&] {
    return haptic::transform_frame_caps(direction, sink_template, src_template, caps, filter);
  });
}

static gboolean gst_velocity_avg_set_caps(GstBaseTransform *trans, GstCaps *in, GstCaps *) {
  return gst_video_info_from_caps(&GST_VELOCITY_AVG(trans)->state->frame, in);
}

static GstFlowReturn gst_velocity_avg_prepare_output_buffer(GstBaseTransform *, GstBuffer *in,
                                                            GstBuffer **out) {
  *out = gst_buffer_new_allocate(nullptr, haptic::kMotionSampleSize, nullptr);
  GST_BUFFER_PTS(*out) = GST_BUFFER_PTS(in);
  GST_BUFFER_DURATION(*out) = GST_BUFFER_DURATION(in);
  if (GST_BUFFER_IS_DISCONT(in))
    GST_BUFFER_FLAG_SET(*out, GST_BUFFER_FLAG_DISCONT);
  return GST_FLOW_OK;
}

static GstFlowReturn gst_velocity_avg_transform(GstBaseTransform *trans, GstBuffer *in,
                                                GstBuffer *out) {
  return guarded(trans, GST_FLOW_ERROR, [&] { return process(GST_VELOCITY_AVG(trans), in, out); });
}

// The pixels are not looked at, so any strides will do.
static gboolean gst_velocity_avg_propose_allocation(GstBaseTransform *, GstQuery *,
                                                    GstQuery *query) {
  gst_query_add_allocation_meta(query, GST_VIDEO_META_API_TYPE, nullptr);
  return TRUE;
}

static gboolean gst_velocity_avg_start(GstBaseTransform *trans) {
  State &state = *GST_VELOCITY_AVG(trans)->state;
  state.reader = {};
  state.told_about_metadata = false;
  return TRUE;
}

static void gst_velocity_avg_set_property(GObject *object, guint id, const GValue *value,
                                          GParamSpec *pspec) {
  Settings &settings = GST_VELOCITY_AVG(object)->state->settings;
  const ObjectLock lock(object);
  switch (id) {
  case kAverage:
    settings.average = static_cast<Average>(g_value_get_enum(value));
    break;
  case kMotionModel:
    settings.motion_model = static_cast<ModelChoice>(g_value_get_enum(value));
    break;
  case kPostMessages:
    settings.post_messages = g_value_get_boolean(value);
    break;
  default:
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
  }
}

static void gst_velocity_avg_get_property(GObject *object, guint id, GValue *value,
                                          GParamSpec *pspec) {
  const Settings &settings = GST_VELOCITY_AVG(object)->state->settings;
  const ObjectLock lock(object);
  switch (id) {
  case kAverage:
    g_value_set_enum(value, static_cast<gint>(settings.average));
    break;
  case kMotionModel:
    g_value_set_enum(value, static_cast<gint>(settings.motion_model));
    break;
  case kPostMessages:
    g_value_set_boolean(value, settings.post_messages);
    break;
  default:
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
  }
}

static void gst_velocity_avg_finalize(GObject *object) {
  delete GST_VELOCITY_AVG(object)->state;
  G_OBJECT_CLASS(gst_velocity_avg_parent_class)->finalize(object);
}

static void gst_velocity_avg_init(GstVelocityAvg *self) {
  self->state = new State;
  gst_video_info_init(&self->state->frame);
  auto *trans = GST_BASE_TRANSFORM(self);
  gst_base_transform_set_qos_enabled(trans, FALSE);
  // Otherwise the base class clears the flag that says that nothing was measured.
  gst_base_transform_set_gap_aware(trans, TRUE);
}

static void gst_velocity_avg_class_init(GstVelocityAvgClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);
  const auto flags = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS |
                                              GST_PARAM_MUTABLE_PLAYING);

  object_class->set_property = gst_velocity_avg_set_property;
  object_class->get_property = gst_velocity_avg_get_property;
  object_class->finalize = gst_velocity_avg_finalize;
  g_object_class_install_property(
      object_class, kAverage,
      g_param_spec_enum("average", "Average", "How the velocities of the points become one",
                        average_type(), static_cast<gint>(Average::model), flags));
  g_object_class_install_property(
      object_class, kMotionModel,
      g_param_spec_enum("motion-model", "Motion Model",
                        "Motion model that is fitted with average=model", motion_model_type(),
                        static_cast<gint>(ModelChoice::automatic), flags));
  g_object_class_install_property(
      object_class, kPostMessages,
      g_param_spec_boolean("post-messages", "Post Messages",
                           "Post an element message haptic-motion for each frame", FALSE, flags));

  gst_element_class_set_static_metadata(
      element_class, "Velocity averager", "Filter/Analyzer/Video",
      "Turns the motion that roitracker found in a frame into one haptic motion sample",
      "Feeling Wind project");
  gst_element_class_add_static_pad_template(element_class, &sink_template);
  gst_element_class_add_static_pad_template(element_class, &src_template);

  transform_class->transform_caps = gst_velocity_avg_transform_caps;
  transform_class->set_caps = gst_velocity_avg_set_caps;
  transform_class->prepare_output_buffer = gst_velocity_avg_prepare_output_buffer;
  transform_class->transform = gst_velocity_avg_transform;
  transform_class->propose_allocation = gst_velocity_avg_propose_allocation;
  transform_class->start = gst_velocity_avg_start;

  gst_type_mark_as_plugin_api(average_type(), static_cast<GstPluginAPIFlags>(0));
  gst_type_mark_as_plugin_api(motion_model_type(), static_cast<GstPluginAPIFlags>(0));
}
