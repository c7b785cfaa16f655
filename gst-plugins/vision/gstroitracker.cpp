// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstroitracker.h"

#include "buffer-timeline.hpp"
#include "exception-barrier.hpp"
#include "gst-raii.hpp"
#include "gsthapticmotionmeta.h"
#include "luma-crop.hpp"
#include "mapped-frame.hpp"
#include "patch-tracker.hpp"
#include "pointer-arbiter.hpp"
#include "pointer-event.hpp"
#include "repetition.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <gst/video/navigation.h>
#include <optional>

GST_DEBUG_CATEGORY_STATIC(roitracker_debug);
#define GST_CAT_DEFAULT roitracker_debug

namespace {

using haptic::guarded;
using haptic::MappedFrame;
using haptic::ObjectLock;
using haptic::Pointer;
using haptic::PointerSource;
using haptic::Rectangle;

using Clock = std::chrono::steady_clock;

enum class Method { fast, opencv };
constexpr Method kDefaultMethod = Method::fast;

std::unique_ptr<haptic::PatchTracker> make_tracker(Method method) {
  return method == Method::fast ? haptic::make_fast_tracker() : haptic::make_opencv_tracker();
}

enum PropertyId : guint {
  kRoiSize = 1,
  kPointerX,
  kPointerY,
  kPointerSource,
  kMethod,
  kMaxPoints,
  kStats,
  kPropertyCount
};

constexpr guint kLargestRoi = 8192; // px

GParamSpec *properties[kPropertyCount];

struct Statistics {
  guint64 frames = 0;
  guint64 measured = 0;
  guint64 still = 0;
  guint64 duplicates = 0;
  guint64 discontinuities = 0;
  guint64 points = 0;
  guint64 tracker_runs = 0;
  std::chrono::nanoseconds tracker_time{0};
};

// What is known about one frame.
struct Finding {
  guint flags = 0;
  GstClockTime interval = 0;
  bool becomes_reference = true;
  std::optional<std::chrono::nanoseconds> tracker_time;
};

using Force = std::array<double, 3>; // N, x to the right, y up, z towards the user

// What one frame is looked at with.
struct Settings {
  Pointer pointer;
  std::optional<Force> force;
  guint roi_size;
  guint max_points;
  Method method;
};

struct State {
  // Object lock: written by the application, by event threads and by the streaming thread.
  haptic::PointerArbiter pointers;
  std::optional<Force> force; // on the device, as it reported last
  Clock::time_point force_reported;
  guint roi_size = 0;
  guint max_points = haptic::kUsualPatches;
  Method method = kDefaultMethod;
  int frame_width = 0; // 0: no caps yet
  int frame_height = 0;
  Statistics statistics;

  // Streaming thread only, or while it is stopped.
  Method tracker_method = kDefaultMethod;
  std::unique_ptr<haptic::PatchTracker> tracker = make_tracker(kDefaultMethod);
  haptic::BufferTimeline timeline;
  haptic::RepetitionJudge repetition;
  haptic::RegionSize region_size;
  haptic::BufferPtr reference; // the earlier frame
  Rectangle moving_crop;       // where motion was last seen; empty: nowhere yet
  bool reference_was_measured = false;
  haptic::Measurement measurement;
  std::vector<std::uint8_t> previous_scratch;
  std::vector<std::uint8_t> current_scratch;
  Pointer notified_pointer;
  bool told_about_tracker = false;

  void forget_motion() {
    repetition.forget();
    moving_crop = {};
    tracker->reset();
    reference_was_measured = false;
  }

  void use(Method wanted) {
    if (std::exchange(tracker_method, wanted) == wanted)
      return;
    tracker = make_tracker(wanted);
    reference_was_measured = false;
  }

  void forget_frames() {
    forget_motion();
    timeline.forget();
    reference.reset();
  }
};

} // namespace

struct _GstRoiTracker {
  GstVideoFilter parent;
  State *state; // made in _init, deleted in _finalize
};

#define ROITRACKER_CAPS GST_VIDEO_CAPS_MAKE(HAPTIC_VIDEO_FORMATS)

static GstStaticPadTemplate sink_template =
    GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS(ROITRACKER_CAPS));
static GstStaticPadTemplate src_template =
    GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(ROITRACKER_CAPS));

G_DEFINE_TYPE_WITH_CODE(GstRoiTracker, gst_roi_tracker, GST_TYPE_VIDEO_FILTER,
                        GST_DEBUG_CATEGORY_INIT(roitracker_debug, "roitracker", 0,
                                                "motion in a region of interest"))
GST_ELEMENT_REGISTER_DEFINE(roitracker, "roitracker", GST_RANK_NONE, GST_TYPE_ROI_TRACKER)

namespace {

GType pointer_source_type() {
  static const GEnumValue values[] = {
      {static_cast<int>(PointerSource::automatic),
       "The haptic device if it spoke within the last second, else mouse or touch, else properties",
       "auto"},
      {static_cast<int>(PointerSource::haptic), "The haptic device", "haptic"},
      {static_cast<int>(PointerSource::navigation), "Mouse or touch screen", "navigation"},
      {static_cast<int>(PointerSource::property), "The properties pointer-x and pointer-y",
       "property"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstRoiTrackerPointerSource", values);
  return type;
}

GType method_type() {
  static const GEnumValue values[] = {
      {static_cast<int>(Method::fast),
       "Still, one translation or a grid of patches, whatever is the least that explains the "
       "frame",
       "fast"},
      {static_cast<int>(Method::opencv),
       "OpenCV's Shi-Tomasi corners and pyramidal Lucas-Kanade, the reference", "opencv"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstRoiTrackerMethod", values);
  return type;
}

GstStructure *make_stats(GstRoiTracker *self) {
  Statistics s;
  {
    const ObjectLock lock(self);
    s = self->state->statistics;
  }
  const auto mean = [](double sum, guint64 count) {
    return count > 0 ? sum / static_cast<double>(count) : 0.0;
  };
  const double microseconds = std::chrono::duration<double, std::micro>(s.tracker_time).count();
  return gst_structure_new("roitracker-stats", "frames", G_TYPE_UINT64, s.frames, "measured",
                           G_TYPE_UINT64, s.measured, "still", G_TYPE_UINT64, s.still, "duplicates",
                           G_TYPE_UINT64, s.duplicates, "discontinuities", G_TYPE_UINT64,
                           s.discontinuities, "points", G_TYPE_DOUBLE,
                           mean(static_cast<double>(s.points), s.measured), "time-mean-us",
                           G_TYPE_DOUBLE, mean(microseconds, s.tracker_runs), nullptr);
}

// Reading the frame

// One frame that the tracker cannot digest is a gap, not the end of the stream.
void run_tracker(GstRoiTracker *self, const haptic::CropPair &pair, GstBuffer *buffer) {
  State &state = *self->state;
  try {
    state.tracker->measure(pair, state.measurement);
  } catch (const std::exception &error) {
    state.measurement.clear();
    state.tracker->reset();
    if (std::exchange(state.told_about_tracker, true))
      return;
    GST_ELEMENT_WARNING(self, STREAM, FAILED,
                        ("The motion of a frame could not be measured; such frames are felt "
                         "as nothing."),
                        ("%s, frame at %" GST_TIME_FORMAT ", region %dx%d+%d+%d", error.what(),
                         GST_TIME_ARGS(GST_BUFFER_PTS(buffer)), pair.region.width,
                         pair.region.height, pair.region.x, pair.region.y));
  }
}

// Compares the frame with the reference. Nothing, if either cannot be read.
std::optional<Finding> compare(GstRoiTracker *self, GstBuffer *buffer, const Rectangle &region,
                               const Rectangle &crop, GstClockTime interval) {
  State &state = *self->state;
  const GstVideoInfo &info = GST_VIDEO_FILTER(self)->in_info;
  const MappedFrame previous(info, state.reference.get());
  const MappedFrame current(info, buffer);
  if (!previous || !current)
    return std::nullopt;

  const haptic::CropPair pair{haptic::luma_crop(previous.frame(), crop, state.previous_scratch),
                              haptic::luma_crop(current.frame(), crop, state.current_scratch), crop,
                              region, state.reference_was_measured};
  state.reference_was_measured = false;
  Finding finding{.interval = interval};

  const bool same_here = haptic::is_identical(pair.previous, pair.current);
  const auto same_there = [&] {
    return haptic::is_identical(
        haptic::luma_crop(previous.frame(), state.moving_crop, state.previous_scratch),
        haptic::luma_crop(current.frame(), state.moving_crop, state.current_scratch));
  };
  switch (state.repetition.judge(same_here, same_there)) {
  case haptic::Repetition::duplicate:
    finding.flags = GST_HAPTIC_MOTION_DUPLICATE;
    // The next interval then spans both, as its displacement does.
    finding.becomes_reference = false;
    return finding;
  case haptic::Repetition::still:
    finding.flags = GST_HAPTIC_MOTION_STILL;
    return finding;
  case haptic::Repetition::none:
    break;
  }

  state.moving_crop = crop;
  const auto begin = Clock::now();
  run_tracker(self, pair, buffer);
  finding.tracker_time = Clock::now() - begin;
  state.reference_was_measured = true;
  finding.flags = state.measurement.flags;
  return finding;
}

// Nothing, if a frame cannot be read. Leaves the patches in state.measurement.
std::optional<Finding> examine(GstRoiTracker *self, GstBuffer *buffer, const Rectangle &region,
                               const Settings &settings) {
  State &state = *self->state;
  state.measurement.clear();
  const haptic::TimeStep step =
      state.timeline.advance(GST_BASE_TRANSFORM(self), GST_CAT_DEFAULT, buffer);

  switch (step.kind) {
  case haptic::TimeStep::Kind::repeats:
    return Finding{.becomes_reference = false};
  case haptic::TimeStep::Kind::restarts:
    state.forget_motion();
    return Finding{.flags = GST_HAPTIC_MOTION_DISCONTINUITY};
  case haptic::TimeStep::Kind::follows:
    break;
  }
  if (!haptic::is_measurable(region))
    return Finding{.interval = step.interval};

  state.use(settings.method);
  state.tracker->set_max_points(static_cast<int>(settings.max_points));
  const int margin = state.tracker->margin(std::max(region.width, region.height));
  const Rectangle crop = haptic::crop_around(region, margin, state.frame_width, state.frame_height);
  return compare(self, buffer, region, crop, step.interval);
}

// Attaching the result

template <typename Remove>
void remove_metas(GstBuffer *buffer, GType api, Remove &&should_go) {
  gpointer cursor = nullptr;
  while (GstMeta *meta = gst_buffer_iterate_meta_filtered(buffer, &cursor, api))
    if (should_go(meta)) {
      gst_buffer_remove_meta(buffer, meta);
      cursor = nullptr;
    }
}

void attach(GstRoiTracker *self, GstBuffer *buffer, const Rectangle &region,
            const Settings &settings, const Finding &finding) {
  State &state = *self->state;
  GstHapticMotionMeta *meta = gst_buffer_get_haptic_motion_meta(buffer);
  if (meta)
    gst_buffer_remove_meta(buffer, &meta->meta);
  meta = gst_buffer_add_haptic_motion_meta(buffer);
  meta->flags = finding.flags;
  meta->frame_width = static_cast<guint>(state.frame_width);
  meta->frame_height = static_cast<guint>(state.frame_height);
  meta->region_x = static_cast<gfloat>(region.x);
  meta->region_y = static_cast<gfloat>(region.y);
  meta->region_width = static_cast<gfloat>(region.width);
  meta->region_height = static_cast<gfloat>(region.height);
  meta->pointer_x = static_cast<gfloat>(settings.pointer.x * state.frame_width);
  meta->pointer_y = static_cast<gfloat>(settings.pointer.y * state.frame_height);
  meta->interval = finding.interval;
  meta->n_candidates = static_cast<guint>(state.measurement.candidates);
  meta->n_patches = static_cast<guint>(state.measurement.count);
  std::ranges::copy(state.measurement.view(), meta->patches);
  if (settings.force) {
    meta->force_x = static_cast<gfloat>((*settings.force)[0]);
    meta->force_y = static_cast<gfloat>((*settings.force)[1]);
    meta->force_z = static_cast<gfloat>((*settings.force)[2]);
  }

  static const GQuark kRoiType = g_quark_from_static_string("haptic-roi");
  remove_metas(buffer, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE, [](GstMeta *other) {
    return reinterpret_cast<GstVideoRegionOfInterestMeta *>(other)->roi_type == kRoiType;
  });
  gst_buffer_add_video_region_of_interest_meta_id(
      buffer, kRoiType, static_cast<guint>(region.x), static_cast<guint>(region.y),
      static_cast<guint>(region.width), static_cast<guint>(region.height));
}

void count(GstRoiTracker *self, const Finding &finding) {
  const State &state = *self->state;
  const ObjectLock lock(self);
  Statistics &s = self->state->statistics;
  ++s.frames;
  s.still += (finding.flags & GST_HAPTIC_MOTION_STILL) != 0;
  s.duplicates += (finding.flags & GST_HAPTIC_MOTION_DUPLICATE) != 0;
  s.discontinuities += (finding.flags & GST_HAPTIC_MOTION_DISCONTINUITY) != 0;
  s.measured += state.measurement.count > 0;
  s.points += static_cast<guint64>(state.measurement.count);
  if (finding.tracker_time) {
    ++s.tracker_runs;
    s.tracker_time += *finding.tracker_time;
  }
}

// Never with a lock held: handlers may do anything.
void notify_pointer(GstRoiTracker *self, const Pointer &pointer) {
  const Pointer before = std::exchange(self->state->notified_pointer, pointer);
  if (pointer.x != before.x)
    g_object_notify_by_pspec(G_OBJECT(self), properties[kPointerX]);
  if (pointer.y != before.y)
    g_object_notify_by_pspec(G_OBJECT(self), properties[kPointerY]);
}

Settings take_settings(GstRoiTracker *self) {
  const ObjectLock lock(self);
  const State &state = *self->state;
  const auto now = Clock::now();
  const bool fresh = now - state.force_reported <= haptic::PointerArbiter::kHapticTimeout;
  return {state.pointers.in_use(now), fresh ? state.force : std::nullopt, state.roi_size,
          state.max_points, state.method};
}

void follow_controllers(GstRoiTracker *self, GstBuffer *buffer) {
  const GstSegment &segment = GST_BASE_TRANSFORM(self)->segment;
  if (segment.format != GST_FORMAT_TIME || !GST_BUFFER_PTS_IS_VALID(buffer))
    return;
  const GstClockTime time =
      gst_segment_to_stream_time(&segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  if (GST_CLOCK_TIME_IS_VALID(time))
    gst_object_sync_values(GST_OBJECT(self), time);
}

GstFlowReturn process(GstRoiTracker *self, GstBuffer *buffer) {
  State &state = *self->state;
  follow_controllers(self, buffer);
  const Settings settings = take_settings(self);
  const int base = settings.roi_size > 0 ? static_cast<int>(settings.roi_size)
                                         : haptic::default_region_side(state.frame_width);
  const int side =
      state.region_size.side(settings.pointer.z, base, state.frame_width, state.frame_height);
  const Rectangle region = haptic::region_at(settings.pointer.x, settings.pointer.y, side,
                                             state.frame_width, state.frame_height);

  const std::optional<Finding> finding = examine(self, buffer, region, settings);
  if (!finding) {
    GST_ELEMENT_ERROR(self, STREAM, FORMAT,
                      ("A frame cannot be read: its memory does not hold what its format says."),
                      ("%" GST_PTR_FORMAT, static_cast<void *>(buffer)));
    return GST_FLOW_ERROR;
  }
  attach(self, buffer, region, settings, *finding);
  if (finding->becomes_reference && GST_BUFFER_PTS_IS_VALID(buffer)) {
    state.timeline.adopt();
    state.reference.reset(gst_buffer_ref(buffer));
  } else if (finding->becomes_reference) {
    state.reference.reset();
  }
  count(self, *finding);
  notify_pointer(self, settings.pointer);
  GST_LOG_OBJECT(self, "region %dx%d+%d+%d, %d of %d patches, flags %x", region.width,
                 region.height, region.x, region.y, state.measurement.count,
                 state.measurement.candidates, finding->flags);
  return GST_FLOW_OK;
}

// Events

void see_navigation(GstRoiTracker *self, GstEvent *event) {
  gdouble x = 0;
  gdouble y = 0;
  if (!gst_navigation_event_get_coordinates(event, &x, &y) || !std::isfinite(x) ||
      !std::isfinite(y))
    return;
  const ObjectLock lock(self);
  State &state = *self->state;
  if (state.frame_width > 0)
    state.pointers.point_navigation({std::clamp(x / state.frame_width, 0.0, 1.0),
                                     std::clamp(y / state.frame_height, 0.0, 1.0)});
}

} // namespace

static GstFlowReturn gst_roi_tracker_transform_ip(GstBaseTransform *trans, GstBuffer *buffer) {
  return guarded(trans, GST_FLOW_ERROR, [&] { return process(GST_ROI_TRACKER(trans), buffer); });
}

static GstFlowReturn gst_roi_tracker_prepare_output_buffer(GstBaseTransform *, GstBuffer *in,
                                                           GstBuffer **out) {
  *out = haptic::with_own_metadata(in);
  return *out ? GST_FLOW_OK : GST_FLOW_ERROR;
}

static gboolean gst_roi_tracker_set_info(GstVideoFilter *filter, GstCaps *, GstVideoInfo *in_info,
                                         GstCaps *, GstVideoInfo *) {
  return guarded(filter, FALSE, [&] {
    State &state = *GST_ROI_TRACKER(filter)->state;
    state.forget_frames();
    const ObjectLock lock(filter);
    state.frame_width = GST_VIDEO_INFO_WIDTH(in_info);
    state.frame_height = GST_VIDEO_INFO_HEIGHT(in_info);
    return TRUE;
  });
}

static gboolean gst_roi_tracker_sink_event(GstBaseTransform *trans, GstEvent *event) {
  guarded(trans, [&] {
    auto *self = GST_ROI_TRACKER(trans);
    switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_SEGMENT:
    case GST_EVENT_FLUSH_STOP:
      self->state->forget_frames();
      break;
    case GST_EVENT_EOS:
      gst_element_post_message(GST_ELEMENT(self),
                               gst_message_new_element(GST_OBJECT(self), make_stats(self)));
      break;
    default:
      break;
    }
  });
  return GST_BASE_TRANSFORM_CLASS(gst_roi_tracker_parent_class)->sink_event(trans, event);
}

static gboolean gst_roi_tracker_src_event(GstBaseTransform *trans, GstEvent *event) {
  const bool is_mine = guarded(trans, false, [&] {
    auto *self = GST_ROI_TRACKER(trans);
    if (GST_EVENT_TYPE(event) == GST_EVENT_NAVIGATION)
      see_navigation(self, event);
    const auto position = haptic::parse_pointer_event(event);
    if (!position)
      return false;
    const ObjectLock lock(self);
    State &state = *self->state;
    const auto now = Clock::now();
    state.pointers.point_haptic({position->x, position->y, position->z}, now);
    state.force = position->force;
    state.force_reported = now;
    return true;
  });
  if (is_mine) {
    gst_event_unref(event);
    return TRUE;
  }
  return GST_BASE_TRANSFORM_CLASS(gst_roi_tracker_parent_class)->src_event(trans, event);
}

static gboolean gst_roi_tracker_query(GstBaseTransform *trans, GstPadDirection direction,
                                      GstQuery *query) {
  // Whoever drains wants every buffer back, the reference too. Serialised with the frames.
  if (GST_QUERY_TYPE(query) == GST_QUERY_DRAIN && direction == GST_PAD_SINK)
    guarded(trans, [&] { GST_ROI_TRACKER(trans)->state->forget_frames(); });
  return GST_BASE_TRANSFORM_CLASS(gst_roi_tracker_parent_class)->query(trans, direction, query);
}

// Frames pass through, so downstream's answer counts (strides of its own, too, only if downstream
// reads them); the reference takes one buffer more.
static gboolean gst_roi_tracker_propose_allocation(GstBaseTransform *trans, GstQuery *,
                                                   GstQuery *query) {
  constexpr guint kHeld = 1;
  GstCaps *caps = nullptr;
  gst_query_parse_allocation(query, &caps, nullptr);
  GstVideoInfo info;
  if (!caps || !gst_video_info_from_caps(&info, caps))
    return FALSE;
  if (!gst_pad_peer_query(GST_BASE_TRANSFORM_SRC_PAD(trans), query))
    GST_DEBUG_OBJECT(trans, "downstream has no wishes for its buffers");

  const guint pools = gst_query_get_n_allocation_pools(query);
  for (guint i = 0; i < pools; ++i) {
    GstBufferPool *pool = nullptr;
    guint size = 0;
    guint least = 0;
    guint most = 0;
    gst_query_parse_nth_allocation_pool(query, i, &pool, &size, &least, &most);
    gst_query_set_nth_allocation_pool(query, i, pool, size, least + kHeld,
                                      most > 0 ? most + kHeld : 0);
    if (pool)
      gst_object_unref(pool);
  }
  if (pools == 0)
    gst_query_add_allocation_pool(query, nullptr, static_cast<guint>(GST_VIDEO_INFO_SIZE(&info)),
                                  1 + kHeld, 0);
  return TRUE;
}

static gboolean gst_roi_tracker_start(GstBaseTransform *trans) {
  return guarded(trans, FALSE, [&] {
    State &state = *GST_ROI_TRACKER(trans)->state;
    state.timeline.tell_again();
    state.told_about_tracker = false;
    const ObjectLock lock(trans);
    state.statistics = {};
    return TRUE;
  });
}

static gboolean gst_roi_tracker_stop(GstBaseTransform *trans) {
  return guarded(trans, FALSE, [&] {
    State &state = *GST_ROI_TRACKER(trans)->state;
    state.forget_frames();
    state.region_size = {};
    const ObjectLock lock(trans);
    state.pointers.forget();
    state.force.reset();
    state.frame_width = 0;
    state.frame_height = 0;
    return TRUE;
  });
}

static void gst_roi_tracker_set_property(GObject *object, guint id, const GValue *value,
                                         GParamSpec *pspec) {
  State &state = *GST_ROI_TRACKER(object)->state;
  const ObjectLock lock(object);
  switch (id) {
  case kRoiSize:
    state.roi_size = g_value_get_uint(value);
    break;
  case kPointerX:
    state.pointers.property.x = g_value_get_double(value);
    break;
  case kPointerY:
    state.pointers.property.y = g_value_get_double(value);
    break;
  case kPointerSource:
    state.pointers.source = static_cast<PointerSource>(g_value_get_enum(value));
    break;
  case kMethod:
    state.method = static_cast<Method>(g_value_get_enum(value));
    break;
  case kMaxPoints:
    state.max_points = g_value_get_uint(value);
    break;
  default:
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
  }
}

static void gst_roi_tracker_get_property(GObject *object, guint id, GValue *value,
                                         GParamSpec *pspec) {
  auto *self = GST_ROI_TRACKER(object);
  if (id == kStats) {
    g_value_take_boxed(value, make_stats(self));
    return;
  }
  State &state = *self->state;
  const ObjectLock lock(object);
  switch (id) {
  case kRoiSize:
    g_value_set_uint(value, state.roi_size);
    break;
  case kPointerX:
    g_value_set_double(value, state.pointers.in_use(Clock::now()).x);
    break;
  case kPointerY:
    g_value_set_double(value, state.pointers.in_use(Clock::now()).y);
    break;
  case kPointerSource:
    g_value_set_enum(value, static_cast<gint>(state.pointers.source));
    break;
  case kMethod:
    g_value_set_enum(value, static_cast<gint>(state.method));
    break;
  case kMaxPoints:
    g_value_set_uint(value, state.max_points);
    break;
  default:
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
  }
}

static void gst_roi_tracker_finalize(GObject *object) {
  delete GST_ROI_TRACKER(object)->state;
  G_OBJECT_CLASS(gst_roi_tracker_parent_class)->finalize(object);
}

static void gst_roi_tracker_init(GstRoiTracker *self) {
  self->state = new State;
  // A late video sink must not make the tracker skip frames.
  gst_base_transform_set_qos_enabled(GST_BASE_TRANSFORM(self), FALSE);
  gst_base_transform_set_gap_aware(GST_BASE_TRANSFORM(self), TRUE);
}

static void install_properties(GObjectClass *object_class) {
  const auto usual = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS |
                                              GST_PARAM_MUTABLE_PLAYING);
  const auto controllable = static_cast<GParamFlags>(usual | GST_PARAM_CONTROLLABLE);
  // The pointer in use changes with the frames, and is announced with them.
  const auto pointer = static_cast<GParamFlags>(controllable | G_PARAM_EXPLICIT_NOTIFY);

  properties[kRoiSize] = g_param_spec_uint(
      "roi-size", "Region Size",
      "Side of the square region of interest about the pointer in pixels; 0: 30 pixels in a "
      "frame 352 pixels wide, and in proportion",
      0, kLargestRoi, 0, controllable);
  properties[kPointerX] = g_param_spec_double(
      "pointer-x", "Pointer X",
      "Pointer as a fraction of the frame's width, from the left. Setting it takes effect while "
      "neither a haptic device nor a mouse points; reading it gives the pointer in use",
      0, 1, 0.5, pointer);
  properties[kPointerY] = g_param_spec_double(
      "pointer-y", "Pointer Y",
      "Pointer as a fraction of the frame's height, from the top. Setting it takes effect while "
      "neither a haptic device nor a mouse points; reading it gives the pointer in use",
      0, 1, 0.5, pointer);
  properties[kPointerSource] =
      g_param_spec_enum("pointer-source", "Pointer Source", "Who moves the pointer",
                        pointer_source_type(), static_cast<gint>(PointerSource::automatic), usual);
  properties[kMethod] = g_param_spec_enum("method", "Method", "How motion is measured",
                                          method_type(), static_cast<gint>(kDefaultMethod), usual);
  properties[kMaxPoints] = g_param_spec_uint("max-points", "Maximum Points",
                                             "Most points that are tracked in the region", 1,
                                             haptic::kMaxPatches, haptic::kUsualPatches, usual);
  properties[kStats] = g_param_spec_boxed(
      "stats", "Statistics",
      "Frames so far, how many of them were measured, still or duplicates, mean number of points "
      "and mean time in the tracker",
      GST_TYPE_STRUCTURE, static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS));
  g_object_class_install_properties(object_class, kPropertyCount, properties);
}

static void gst_roi_tracker_class_init(GstRoiTrackerClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);

  object_class->set_property = gst_roi_tracker_set_property;
  object_class->get_property = gst_roi_tracker_get_property;
  object_class->finalize = gst_roi_tracker_finalize;
  install_properties(object_class);

  gst_element_class_set_static_metadata(
      element_class, "Region of interest tracker", "Filter/Analyzer/Video",
      "Measures the motion of what a pointer rests on and attaches it to the untouched frame",
      "Feeling Wind project");
  gst_element_class_add_static_pad_template(element_class, &sink_template);
  gst_element_class_add_static_pad_template(element_class, &src_template);

  // Without it the base class works in place only; GstVideoFilter's own transform_ip would map the
  // pixels for writing, and copy them.
  transform_class->transform = nullptr;
  transform_class->transform_ip = gst_roi_tracker_transform_ip;
  transform_class->prepare_output_buffer = gst_roi_tracker_prepare_output_buffer;
  transform_class->sink_event = gst_roi_tracker_sink_event;
  transform_class->src_event = gst_roi_tracker_src_event;
  transform_class->query = gst_roi_tracker_query;
  transform_class->propose_allocation = gst_roi_tracker_propose_allocation;
  transform_class->start = gst_roi_tracker_start;
  transform_class->stop = gst_roi_tracker_stop;
  GST_VIDEO_FILTER_CLASS(klass)->set_info = gst_roi_tracker_set_info;

  gst_type_mark_as_plugin_api(pointer_source_type(), static_cast<GstPluginAPIFlags>(0));
  gst_type_mark_as_plugin_api(method_type(), static_cast<GstPluginAPIFlags>(0));
}
