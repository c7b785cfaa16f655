// SPDX-License-Identifier: LGPL-2.1-or-later
// motionfield measures the motion of a whole frame on a grid of cells, so that a receiver can feel
// any place of it.
//
//   gst-launch-1.0 videotestsrc pattern=ball ! motionfield ! hapticsink
//
// It reads the luma of each frame once.
#include "field/camera-motion.hpp"
#include "field/field-tracker.hpp"
#include "frames/buffer-timeline.hpp"
#include "frames/frame-caps.hpp"
#include "frames/luma-crop.hpp"
#include "frames/mapped-frame.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/property-table.hpp"
#include "glue/segment-time.hpp"
#include "glue/stream-lock.hpp"
#include "hold-point.hpp"
#include "hold/followed-things.hpp"
#include "messages.hpp"
#include "samples/motion-field.hpp"
#include "tracking/repetition.hpp"

#include <algorithm>
#include <gst/base/gstbasetransform.h>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>

G_DECLARE_FINAL_TYPE(GstMotionField, gst_motion_field, GST, MOTION_FIELD, GstBaseTransform)

GST_DEBUG_CATEGORY_STATIC(motionfield_debug);
#define GST_CAT_DEFAULT motionfield_debug

namespace {

using haptic::guarded;
using haptic::HoldPoint;
using haptic::kGuarded;
using haptic::MotionField;

// State

// Of the metadata and the message that name what was subtracted.
constexpr char kCameraMotion[] = "haptic-camera-motion";

enum class Camera { keep, remove };

struct Settings {
  guint columns = haptic::kFieldColumns;
  Camera camera = Camera::keep;
  guint things = 0;       // that it chooses by itself
  std::string points;     // as given
  guint points_given = 0; // times
};

struct State {
  // Object lock: written by the application, read by the streaming thread.
  Settings settings;

  // Streaming thread only, or while it is stopped.
  GstVideoInfo frame; // of the caps
  haptic::FieldShape shape;
  haptic::FieldTracker tracker;
  haptic::BufferTimeline timeline;
  haptic::RepetitionJudge repetition;
  MotionField field;                   // a duplicate frame repeats its cells
  Camera camera_choice = Camera::keep; // for this frame
  haptic::CameraMotion camera;         // that was subtracted from the cells
  haptic::MotionModel announced_camera = haptic::MotionModel::none;
  bool follows = false;             // things, in this frame
  guint things_wanted = 0;          // in this frame
  std::optional<guint> points_read; // Settings::points_given
  std::vector<HoldPoint> points;    // not yet taken, of running time
  haptic::FollowedThings things;
  std::optional<GstClockTime> since_choice; // ns; none was made in this scene
  std::vector<std::uint8_t> scratch;

  void forget_frames() {
    repetition.forget();
    timeline.forget();
    tracker.forget();
    forget_things();
  }

  void forget_things() {
    things.forget();
    since_choice.reset();
  }
};

} // namespace

struct _GstMotionField {
  GstBaseTransform parent;
  State *state; // made in _init, deleted in _finalize
};

G_DEFINE_TYPE_WITH_CODE(GstMotionField, gst_motion_field, GST_TYPE_BASE_TRANSFORM,
                        GST_DEBUG_CATEGORY_INIT(motionfield_debug, "motionfield", 0,
                                                "motion of the whole frame"))
GST_ELEMENT_REGISTER_DEFINE(motionfield, "motionfield", GST_RANK_NONE, gst_motion_field_get_type())

namespace {

// Properties

std::span<const haptic::Property<Settings>> properties() {
  using Rows = haptic::Rows<Settings>;
  constexpr guint kFewestColumns = 4;
  constexpr guint kMostColumns = 96;
  static const haptic::Property<Settings> table[] = {
      Rows::number<&Settings::columns>(
          "field-columns", "Field Columns",
          "Cells side by side; rows follow from the frame's shape. None is narrower than 8 pixels",
          kFewestColumns, kMostColumns),
      Rows::choice<&Settings::camera>(
          "camera", "Camera", "Whether the camera's motion stays in the field or is subtracted",
          haptic::register_enum<Camera>(
              "GstMotionFieldCamera",
              {{Camera::keep, "The motion in the frame, as it is", "keep"},
               {Camera::remove, "The motion relative to the background", "remove"}})),
      Rows::number<&Settings::things>(
          "things", "Things",
          "Things that the element chooses, follows, and says the places of in each field; a "
          "receiver can hold them",
          0, haptic::kMostFieldThings),
      {g_param_spec_string(
           "points", "Points",
           "Places whose things are followed: X,Y from 0 to 1, or X,Y@SECONDS of the running time, "
           "with spaces between them",
           nullptr, haptic::kReadWrite),
       [](Settings &settings, const GValue *value) {
         const gchar *given = g_value_get_string(value);
         settings.points = given ? given : "";
         ++settings.points_given;
       },
       [](const Settings &settings, GValue *value) {
         g_value_set_string(value, settings.points.empty() ? nullptr : settings.points.c_str());
       }},
  };
  return table;
}

// Things to hold

std::vector<HoldPoint> points_of(GstMotionField *self, const std::string &text) {
  std::vector<HoldPoint> points;
  std::istringstream words(text);
  for (std::string word; words >> word;)
    if (const auto point = haptic::read_hold_point(word))
      points.push_back(*point);
    else
      GST_WARNING_OBJECT(self, "\"%s\" is no place", word.c_str());
  return points;
}

void follow_settings(GstMotionField *self, const Settings &settings) {
  State &state = *self->state;
  state.things_wanted = settings.things;
  if (std::exchange(state.points_read, settings.points_given) != settings.points_given) {
    state.points = points_of(self, settings.points);
    state.things = {}; // numbered from 1 again, after a discontinuity
    state.forget_frames();
  }
  state.follows = settings.things > 0 || !settings.points.empty();
  if (state.follows)
    return;
  state.forget_things();
  state.field.things.clear();
}

// Takes what is under the points whose time has come. Containers round times to 1 ms.
void take_points(GstMotionField *self, const haptic::LumaSource &luma, GstClockTime time) {
  State &state = *self->state;
  std::erase_if(state.points, [&](const HoldPoint &point) {
    const bool is_due = GST_CLOCK_TIME_IS_VALID(time) &&
                        static_cast<double>(time + GST_MSECOND) >= point.time * GST_SECOND;
    if (is_due)
      state.things.take(luma, GST_VIDEO_INFO_WIDTH(&state.frame),
                        GST_VIDEO_INFO_HEIGHT(&state.frame), static_cast<float>(point.x),
                        static_cast<float>(point.y));
    return is_due;
  });
}

// Chooses things once a second. In the first frame of a scene nothing has moved yet.
void choose_things(State &state, const haptic::LumaSource &luma) {
  constexpr GstClockTime kEvery = GST_SECOND;
  if (state.since_choice)
    *state.since_choice += state.field.interval;
  if (state.since_choice.value_or(kEvery) < kEvery)
    return;
  state.things.choose(luma, state.field, state.things_wanted);
  state.since_choice = 0;
}

// Follows the things into this frame, after its motion was measured, and takes others.
void follow_things(GstMotionField *self, GstBuffer *buffer) {
  State &state = *self->state;
  MotionField &field = state.field;
  const haptic::MappedFrame frame(state.frame, buffer);
  if (!frame)
    return;
  const haptic::FrameLuma luma(frame.frame());
  const float seconds = static_cast<float>(field.interval) / static_cast<float>(GST_SECOND);
  const bool begins = (field.flags & (haptic::kMotionCut | haptic::kMotionDiscontinuity)) != 0;
  if (begins)
    state.forget_things();
  else if ((field.flags & haptic::kMotionStill) != 0)
    state.things.rest(luma, seconds);
  else
    state.things.follow(luma, seconds);
  take_points(self, luma,
              haptic::running_time_of(GST_BASE_TRANSFORM(self)->segment, GST_BUFFER_PTS(buffer)));
  if (!begins)
    choose_things(state, luma);
  state.things.write(GST_VIDEO_INFO_WIDTH(&state.frame), GST_VIDEO_INFO_HEIGHT(&state.frame),
                     field.things);
}

// Measuring a frame

// Follows the frame's size and the properties. A change of the shape forgets the earlier frames.
void set_shape(GstMotionField *self) {
  State &state = *self->state;
  const GstVideoInfo &info = state.frame;
  const Settings settings = haptic::locked_copy(self, state.settings);
  state.camera_choice = settings.camera;
  follow_settings(self, settings);
  const int width = GST_VIDEO_INFO_WIDTH(&info);
  const int height = GST_VIDEO_INFO_HEIGHT(&info);
  const haptic::FieldShape shape = haptic::field_shape(
      width, height, static_cast<double>(GST_VIDEO_INFO_PAR_N(&info)) / GST_VIDEO_INFO_PAR_D(&info),
      static_cast<int>(settings.columns));
  MotionField &field = state.field;
  if (shape == state.shape && field.frame_width == static_cast<std::uint32_t>(width) &&
      field.frame_height == static_cast<std::uint32_t>(height))
    return;
  state.shape = shape;
  state.forget_frames();
  state.tracker.set_frame(width, height, shape);
  field.frame_width = static_cast<std::uint32_t>(width);
  field.frame_height = static_cast<std::uint32_t>(height);
  field.columns = static_cast<std::uint16_t>(shape.columns);
  field.rows = static_cast<std::uint16_t>(shape.rows);
  field.cells.assign(static_cast<std::size_t>(shape.cells()), {});
}

// Passes the luma to the tracker, strip by strip. Returns false if the frame cannot be read.
bool read(State &state, GstBuffer *buffer) {
  const haptic::MappedFrame frame(state.frame, buffer);
  if (!frame)
    return false;
  const int width = GST_VIDEO_INFO_WIDTH(&state.frame);
  const int height = GST_VIDEO_INFO_HEIGHT(&state.frame);
  const int strip = state.tracker.strip_rows();
  for (int y = 0; y < height; y += strip)
    state.tracker.read(haptic::luma_crop(frame.frame(), {0, y, width, std::min(strip, height - y)},
                                         state.scratch));
  return true;
}

// Subtracts what the background says about the camera.
void remove_camera(State &state) {
  MotionField &field = state.field;
  state.camera =
      haptic::find_camera_motion(field.cells, state.shape, field.frame_width, field.frame_height,
                                 static_cast<double>(field.interval) / GST_SECOND);
  haptic::subtract(state.camera, field.cells, state.shape, field.frame_width, field.frame_height);
}

// Measures the motion from the reference to the frame that was just read. Returns whether this
// frame becomes the reference: a duplicate does not, so that the next interval spans both frames,
// as the motion does.
bool compare(State &state) {
  MotionField &field = state.field;
  switch (state.repetition.judge(state.tracker.repeats(), [] { return true; })) {
  case haptic::Repetition::duplicate:
    field.flags = haptic::kMotionDuplicate;
    return false;
  case haptic::Repetition::still:
    field.flags = haptic::kMotionStill;
    state.camera = {.model = haptic::MotionModel::still};
    std::ranges::fill(field.cells, haptic::FieldCell{.confidence = 1});
    return true;
  case haptic::Repetition::none:
    break;
  }
  field.flags = static_cast<std::uint16_t>(
      state.tracker.measure(static_cast<double>(field.interval) / GST_SECOND, field.cells));
  if (state.camera_choice == Camera::remove)
    remove_camera(state);
  return true;
}

// Leaves the result in state.field. Returns false if the frame cannot be read.
bool examine(GstMotionField *self, GstBuffer *buffer) {
  State &state = *self->state;
  MotionField &field = state.field;
  field.interval = 0;
  field.flags = 0;
  const haptic::TimeStep step =
      state.timeline.advance(GST_BASE_TRANSFORM(self), GST_CAT_DEFAULT, buffer);
  if (step.kind == haptic::TimeStep::Kind::repeats) {
    std::ranges::fill(field.cells, haptic::FieldCell{});
    return true;
  }
  if (!read(state, buffer))
    return false;
  bool becomes_reference = true;
  if (step.kind == haptic::TimeStep::Kind::follows) {
    field.interval = step.interval;
    becomes_reference = compare(state);
  } else {
    state.repetition.forget();
    state.tracker.forget();
    field.flags = haptic::kMotionDiscontinuity;
    state.camera = {};
    std::ranges::fill(field.cells, haptic::FieldCell{});
  }
  if (becomes_reference) {
    if (state.follows)
      follow_things(self, buffer);
    state.tracker.keep();
    state.timeline.adopt();
  }
  return true;
}

// The camera's motion on the stream

GstStructure *add_camera(const haptic::CameraMotion &camera, GstStructure *fields) {
  const std::string model(haptic::motion_model_name(camera.model));
  gst_structure_set(fields, "model", G_TYPE_STRING, model.c_str(), "velocity-x", G_TYPE_DOUBLE,
                    camera.x, "velocity-y", G_TYPE_DOUBLE, camera.y, "gradient-xx", G_TYPE_DOUBLE,
                    camera.gradient[0], "gradient-xy", G_TYPE_DOUBLE, camera.gradient[1],
                    "gradient-yx", G_TYPE_DOUBLE, camera.gradient[2], "gradient-yy", G_TYPE_DOUBLE,
                    camera.gradient[3], nullptr);
  return fields;
}

// On each field, and as a message when another model begins.
void say_camera(GstMotionField *self, GstBuffer *out) {
  State &state = *self->state;
  add_camera(state.camera,
             gst_custom_meta_get_structure(gst_buffer_add_custom_meta(out, kCameraMotion)));
  if (state.announced_camera == state.camera.model)
    return;
  state.announced_camera = state.camera.model;
  gst_element_post_message(
      GST_ELEMENT(self),
      gst_message_new_element(GST_OBJECT(self),
                              add_camera(state.camera, gst_structure_new_empty(kCameraMotion))));
}

// Streaming

GstFlowReturn transform(GstMotionField *self, GstBuffer *frame, GstBuffer *out) {
  State &state = *self->state;
  if (!examine(self, frame)) {
    GST_ELEMENT_ERROR(self, STREAM, FORMAT, (haptic::messages::kUnreadableFrame),
                      ("%" GST_PTR_FORMAT, static_cast<void *>(frame)));
    return GST_FLOW_ERROR;
  }
  const MotionField &field = state.field;
  GstMapInfo map;
  gst_buffer_set_size(out, static_cast<gssize>(haptic::packed_size(field)));
  if (!gst_buffer_map(out, &map, GST_MAP_WRITE))
    return GST_FLOW_ERROR;
  haptic::pack_motion_field(field, {map.data, map.size});
  gst_buffer_unmap(out, &map);
  if (state.camera_choice == Camera::remove)
    say_camera(self, out);
  const auto known =
      std::ranges::count_if(field.cells, [](const auto &cell) { return cell.confidence > 0; });
  if (known == 0 && field.things.empty())
    GST_BUFFER_FLAG_SET(out, GST_BUFFER_FLAG_GAP);
  GST_LOG_OBJECT(self, "%u x %u cells, %d of them known, flags %x", field.columns, field.rows,
                 static_cast<int>(known), field.flags);
  return GST_FLOW_OK;
}

gboolean set_caps(GstMotionField *self, GstCaps *in) {
  State &state = *self->state;
  state.forget_frames();
  if (!gst_video_info_from_caps(&state.frame, in))
    return FALSE;
  state.field.pixel_aspect_n = static_cast<std::uint32_t>(GST_VIDEO_INFO_PAR_N(&state.frame));
  state.field.pixel_aspect_d = static_cast<std::uint32_t>(GST_VIDEO_INFO_PAR_D(&state.frame));
  return TRUE;
}

GstFlowReturn prepare_output_buffer(GstMotionField *self, GstBuffer *in, GstBuffer **out) {
  set_shape(self);
  constexpr std::size_t kMostThings =
      haptic::kThingsHeader + haptic::kMostFieldThings * haptic::kThingSize;
  const State &state = *self->state;
  // How many things there are is known when the frame has been read.
  *out = gst_buffer_new_allocate(
      nullptr, haptic::packed_size(state.field) + (state.follows ? kMostThings : 0), nullptr);
  haptic::copy_timing(in, *out);
  return GST_FLOW_OK;
}

void on_sink_event(GstMotionField *self, GstEvent *event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_SEGMENT && GST_EVENT_TYPE(event) != GST_EVENT_FLUSH_STOP)
    return;
  self->state->forget_frames();
  self->state->points_read.reset();
}

} // namespace

static void gst_motion_field_class_init(GstMotionFieldClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  haptic::describe(element_class, "motionfield", "Motion field", "Filter/Analyzer/Video",
                   "Measures the motion of the whole frame on a grid of cells",
                   GST_VIDEO_CAPS_MAKE(HAPTIC_VIDEO_FORMATS), HAPTIC_FIELD_CAPS);
  static const gchar *no_tags[] = {nullptr};
  gst_meta_register_custom(kCameraMotion, no_tags, nullptr, nullptr, nullptr);

  auto *object_class = G_OBJECT_CLASS(klass);
  object_class->finalize = haptic::delete_state<GstMotionField, gst_motion_field_parent_class>;
  haptic::install_properties<properties>(object_class, [](GObject *object) -> Settings & {
    return GST_MOTION_FIELD(object)->state->settings;
  });

  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);
  transform_class->transform_caps = kGuarded<haptic::transform_frame_caps>;
  transform_class->set_caps = kGuarded<set_caps>;
  transform_class->prepare_output_buffer = kGuarded<prepare_output_buffer>;
  transform_class->transform = kGuarded<transform>;
  transform_class->sink_event = [](GstBaseTransform *trans, GstEvent *event) {
    guarded(trans, [&] { on_sink_event(GST_MOTION_FIELD(trans), event); });
    return GST_BASE_TRANSFORM_CLASS(gst_motion_field_parent_class)->sink_event(trans, event);
  };
  transform_class->propose_allocation = kGuarded<haptic::accept_any_strides>;
  transform_class->stop = kGuarded<[](GstMotionField *self) {
    const haptic::StreamLock stream(self);
    self->state->forget_frames();
    self->state->points_read.reset();
    self->state->announced_camera = haptic::MotionModel::none;
    self->state->timeline.report_faults_again();
    return TRUE;
  }>;
}

static void gst_motion_field_init(GstMotionField *self) {
  self->state = new State;
  gst_video_info_init(&self->state->frame);
  haptic::keep_every_frame(GST_BASE_TRANSFORM(self));
}
