// SPDX-License-Identifier: LGPL-2.1-or-later
// roitracker measures the motion in a region of interest around a pointer, and attaches it to the
// frame as metadata. It reads the luma of the region only and leaves the pixels as they are.
//
//   gst-launch-1.0 videotestsrc pattern=ball ! roitracker ! velocityavg ! hapticsink
//
// The pointer comes from the application, from navigation events, or from pointer events
// (docs/formats/pointer-event.md), which travel upstream from hapticsink.
#include "elements/analytics-meta.hpp"
#include "elements/marked-object.hpp"
#include "elements/motion-reader.hpp"
#include "frames/buffer-timeline.hpp"
#include "frames/frame-caps.hpp"
#include "frames/luma-crop.hpp"
#include "frames/mapped-frame.hpp"
#include "glue/controllers.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/pointer-event.hpp"
#include "glue/property-table.hpp"
#include "glue/stream-lock.hpp"
#include "gsthapticmotionmeta.h"
#include "hold/held-thing.hpp"
#include "messages.hpp"
#include "tracking/pointer-arbiter.hpp"
#include "tracking/region-tracker.hpp"
#include "tracking/tracking-statistics.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <gst/video/gstvideofilter.h>
#include <gst/video/navigation.h>
#include <optional>
#include <span>

G_DECLARE_FINAL_TYPE(GstRoiTracker, gst_roi_tracker, GST, ROI_TRACKER, GstVideoFilter)

GST_DEBUG_CATEGORY_STATIC(roitracker_debug);
#define GST_CAT_DEFAULT roitracker_debug

namespace {

using haptic::Finding;
using haptic::guarded;
using haptic::HoldState;
using haptic::kGuarded;
using haptic::MappedFrame;
using haptic::ObjectLock;
using haptic::Pointer;
using haptic::PointerSource;
using haptic::Rectangle;
using haptic::TrackerMethod;

using Clock = std::chrono::steady_clock;
namespace messages = haptic::messages;

// What the region is while no thing is followed.
enum class RegionShape { square, object };

// When the thing under the pointer is taken.
enum class HoldMode { off, pressed, latched };

// State

// Object lock: written by the application, by event threads and by the streaming thread.
struct Shared {
  haptic::PointerArbiter pointers;
  guint roi_size = 0; // px; 0: from the frame's width
  guint max_points = haptic::kUsualPatches;
  TrackerMethod method = TrackerMethod::layers;
  RegionShape region = RegionShape::square;
  HoldMode hold = HoldMode::pressed;
  bool let_go = false;         // since the frame before
  std::optional<guint> finger; // of a touch screen that points
  int frame_width = 0;         // px; 0: no caps yet
  int frame_height = 0;
  haptic::TrackingStatistics statistics;
};

struct State {
  Shared shared;

  // Streaming thread only, or while it is stopped.
  haptic::BufferTimeline timeline;
  haptic::RegionSize region_size;
  haptic::RegionTracker tracker;
  haptic::MotionReader reader;
  haptic::AnalyticsWriter analytics;
  haptic::BufferPtr reference; // the earlier frame
  haptic::HeldThing thing;
  std::optional<Rectangle> taken_object;    // of the thing; px from its place
  std::optional<Rectangle> object;          // of a detector, in the frame before
  GstClockTime held_time = 0;               // ns since it was taken
  GstClockTime taken = GST_CLOCK_TIME_NONE; // time stamp of the frame in which it was
  bool was_pressed = false;                 // in the frame before
  Pointer notified_pointer;
  bool warned_of_tracker = false;

  void forget_frames() {
    tracker.forget();
    timeline.forget();
    reference.reset();
    thing.lose();
  }
  void release() {
    thing.release();
    was_pressed = false;
  }
};

// A copy for one frame.
struct Settings {
  Pointer pointer;
  std::optional<haptic::Force> force;
  std::optional<haptic::ProxyPosition> proxy;
  guint roi_size;
  guint max_points;
  TrackerMethod method;
  RegionShape region;
  bool holds;
  bool let_go; // since the frame before
};

} // namespace

struct _GstRoiTracker {
  GstVideoFilter parent;
  State *state; // made in _init, deleted in _finalize
};

#define ROITRACKER_CAPS GST_VIDEO_CAPS_MAKE(HAPTIC_VIDEO_FORMATS)

G_DEFINE_TYPE_WITH_CODE(GstRoiTracker, gst_roi_tracker, GST_TYPE_VIDEO_FILTER,
                        GST_DEBUG_CATEGORY_INIT(roitracker_debug, "roitracker", 0,
                                                "motion in a region of interest"))
GST_ELEMENT_REGISTER_DEFINE(roitracker, "roitracker", GST_RANK_NONE, gst_roi_tracker_get_type())

namespace {

// Properties

GstStructure *to_structure(const haptic::TrackingStatistics &s) {
  return gst_structure_new("roitracker-stats", "frames", G_TYPE_UINT64, s.frames, "measured",
                           G_TYPE_UINT64, s.measured, "still", G_TYPE_UINT64, s.still, "duplicates",
                           G_TYPE_UINT64, s.duplicates, "discontinuities", G_TYPE_UINT64,
                           s.discontinuities, "points", G_TYPE_DOUBLE, s.mean_points(),
                           "time-mean-us", G_TYPE_DOUBLE, s.mean_time(), nullptr);
}

void write_statistics(const Shared &shared, GValue *value) {
  g_value_take_boxed(value, to_structure(shared.statistics));
}

// Setting a pointer property moves the property's own pointer; reading it gives the one in use.
template <double Pointer::*kAxis>
haptic::Property<Shared> pointer_row(const char *name, const char *nick, const char *blurb) {
  // It changes with the frames, and is announced with them.
  constexpr auto kFlags = static_cast<GParamFlags>(haptic::kControllable | G_PARAM_EXPLICIT_NOTIFY);
  return {g_param_spec_double(name, nick, blurb, 0, 1, 0.5, kFlags),
          [](Shared &shared, const GValue *value) {
            haptic::read_value(value, shared.pointers.property.*kAxis);
          },
          [](const Shared &shared, GValue *value) {
            g_value_set_double(value, shared.pointers.in_use(Clock::now()).*kAxis);
          }};
}

bool holds(const Shared &shared, Clock::time_point now) {
  return shared.hold == HoldMode::latched ||
         (shared.hold == HoldMode::pressed && shared.pointers.in_use(now).pressed);
}

// Runs what may press or let go. Both may happen between two frames: that is another press.
template <typename Change>
void change_hold(Shared &shared, Change &&change) {
  const auto now = Clock::now();
  const bool held = holds(shared, now);
  change();
  shared.let_go = shared.let_go || (held && !holds(shared, now));
}

std::span<const haptic::Property<Shared>> properties() {
  using Rows = haptic::Rows<Shared>;
  constexpr guint kLargestRoi = 8192; // px
  static const haptic::Property<Shared> hold = Rows::choice<&Shared::hold>(
      "hold", "Hold", "When the thing under the pointer is taken",
      haptic::register_enum<HoldMode>(
          "GstRoiTrackerHold",
          {{HoldMode::off, "The region stays under the pointer", "off"},
           {HoldMode::pressed,
            "While the pointer is pressed, the region follows the thing that was under it",
            "pressed"},
           {HoldMode::latched,
            "The region follows the thing that is under the pointer now, pressed or not, until "
            "this is set again",
            "latched"}}));
  static const haptic::Property<Shared> table[] = {
      Rows::number<&Shared::roi_size>(
          "roi-size", "Region Size",
          "Side of the square region of interest about the pointer in pixels; 0: 30 pixels in a "
          "frame 352 pixels wide, and in proportion",
          0, kLargestRoi, haptic::kControllable),
      pointer_row<&Pointer::x>(
          "pointer-x", "Pointer X",
          "Pointer as a fraction of the frame's width, from the left. Setting it takes effect "
          "while neither a haptic device nor a mouse points; reading it gives the pointer in use"),
      pointer_row<&Pointer::y>(
          "pointer-y", "Pointer Y",
          "Pointer as a fraction of the frame's height, from the top. Setting it takes effect "
          "while neither a haptic device nor a mouse points; reading it gives the pointer in use"),
      Rows::choice<&Shared::pointers, &haptic::PointerArbiter::source>(
          "pointer-source", "Pointer Source", "Who moves the pointer",
          haptic::register_enum<PointerSource>(
              "GstRoiTrackerPointerSource",
              {{PointerSource::automatic,
                "The haptic device if it spoke within the last second, else mouse or touch, else "
                "properties",
                "auto"},
               {PointerSource::haptic, "The haptic device", "haptic"},
               {PointerSource::navigation, "Mouse or touch screen", "navigation"},
               {PointerSource::property, "The properties pointer-x and pointer-y", "property"}})),
      Rows::choice<&Shared::method>(
          "method", "Method", "How motion is measured",
          haptic::register_enum<TrackerMethod>(
              "GstRoiTrackerMethod",
              {{TrackerMethod::fast,
                "Still, one translation or a grid of patches, whatever is the least that explains "
                "the pixels",
                "fast"},
               {TrackerMethod::opencv,
                "OpenCV's Shi-Tomasi corners and pyramidal Lucas-Kanade, the reference", "opencv"},
               {TrackerMethod::layers,
                "Still, one translation, or what moves before a background, with patches that "
                "cover the region evenly",
                "layers"}})),
      Rows::choice<&Shared::region>(
          "region", "Region", "What is measured about the pointer",
          haptic::register_enum<RegionShape>(
              "GstRoiTrackerRegion",
              {{RegionShape::square, "The square of roi-size", "square"},
               {RegionShape::object,
                "The smallest object under the pointer that an element before this one marked in "
                "the frame, else the square",
                "object"}})),
      {g_param_spec_boolean("pressed", "Pressed",
                            "Whether the pointer of the properties is pressed; reading it gives "
                            "that of the pointer in use",
                            FALSE, static_cast<GParamFlags>(haptic::kControllable)),
       [](Shared &shared, const GValue *value) {
         change_hold(shared, [&] { haptic::read_value(value, shared.pointers.property.pressed); });
       },
       [](const Shared &shared, GValue *value) {
         g_value_set_boolean(value, shared.pointers.in_use(Clock::now()).pressed);
       }},
      {hold.spec,
       [](Shared &shared, const GValue *value) {
         change_hold(shared, [&] { hold.set(shared, value); });
         shared.let_go = shared.let_go || shared.hold == HoldMode::latched; // another thing now
       },
       hold.get},
      Rows::number<&Shared::max_points>("max-points", "Maximum Points",
                                        "Most points that are tracked in the region", 1,
                                        haptic::kMaxPatches),
      {g_param_spec_boxed(
           "stats", "Statistics",
           "Frames so far, how many of them were measured, still or duplicates, mean number of "
           "points and mean time from two frames to points",
           GST_TYPE_STRUCTURE, haptic::kReadOnly),
       nullptr, write_statistics},
  };
  return table;
}

// Measuring a frame

void warn_of_tracker(GstRoiTracker *self, GstBuffer *buffer, const Rectangle &region,
                     const std::string &reason) {
  if (std::exchange(self->state->warned_of_tracker, true))
    return;
  GST_ELEMENT_WARNING(self, STREAM, FAILED, (messages::kNotMeasured),
                      ("%s, frame at %" GST_TIME_FORMAT ", region %dx%d+%d+%d", reason.c_str(),
                       GST_TIME_ARGS(GST_BUFFER_PTS(buffer)), region.width, region.height, region.x,
                       region.y));
}

// Compares the frame with the reference. Nothing, if either cannot be read.
std::optional<Finding> compare(GstRoiTracker *self, GstBuffer *buffer, const Rectangle &region,
                               GstClockTime interval) {
  State &state = *self->state;
  const GstVideoInfo &info = GST_VIDEO_FILTER(self)->in_info;
  const MappedFrame earlier(info, state.reference.get());
  const MappedFrame frame(info, buffer);
  if (!earlier || !frame)
    return std::nullopt;
  const haptic::Areas areas =
      state.tracker.areas(region, GST_VIDEO_INFO_WIDTH(&info), GST_VIDEO_INFO_HEIGHT(&info));
  Finding finding = state.tracker.compare(haptic::FrameLuma(earlier.frame()),
                                          haptic::FrameLuma(frame.frame()), areas, interval);
  if (!finding.error.empty())
    warn_of_tracker(self, buffer, region, finding.error);
  return finding;
}

// Leaves the patches in the tracker. Nothing, if a frame cannot be read.
std::optional<Finding> measure(GstRoiTracker *self, GstBuffer *buffer, const Rectangle &region,
                               const Settings &settings) {
  State &state = *self->state;
  state.tracker.clear_measurement();
  const haptic::TimeStep step =
      state.timeline.advance(GST_BASE_TRANSFORM(self), GST_CAT_DEFAULT, buffer);

  switch (step.kind) {
  case haptic::TimeStep::Kind::repeats:
    return Finding{.becomes_reference = false};
  case haptic::TimeStep::Kind::restarts:
    state.tracker.forget();
    return Finding{.flags = haptic::kMotionDiscontinuity};
  case haptic::TimeStep::Kind::follows:
    break;
  }
  if (!haptic::is_measurable(region)) {
    state.tracker.skip();
    return Finding{.interval = step.interval};
  }
  state.tracker.set_method(settings.method, static_cast<int>(settings.max_points));
  std::optional<Finding> finding = compare(self, buffer, region, step.interval);
  if (finding)
    finding->interval = step.interval;
  return finding;
}

// Returns the pixel of a place. A place on the right or lower border belongs to the last pixel.
int pixel_at(double place, int size) {
  return std::clamp(static_cast<int>(std::floor(place)), 0, size - 1);
}

// A detector's box trembles: it keeps its size until a side changes by more than a tenth.
Rectangle steadied(Rectangle object, const std::optional<Rectangle> &before, int width,
                   int height) {
  const auto is_near = [](int now, int then) { return 10 * std::abs(now - then) <= then; };
  if (!before || !is_near(object.width, before->width) || !is_near(object.height, before->height))
    return object;
  object.x += (object.width - before->width) / 2;
  object.y += (object.height - before->height) / 2;
  object.width = before->width;
  object.height = before->height;
  return haptic::crop_around(object, 0, width, height);
}

// What another element marked under the pointer, if that is asked for and nothing is followed. Of a
// large one the part about the pointer: the cost of a frame does not depend on its size.
std::optional<Rectangle> object_under_pointer(State &state, GstBuffer *buffer,
                                              const GstVideoInfo &info, const Settings &settings) {
  if (settings.region == RegionShape::square || haptic::is_followed(state.thing.report().state))
    return std::nullopt;
  const int width = GST_VIDEO_INFO_WIDTH(&info);
  const int height = GST_VIDEO_INFO_HEIGHT(&info);
  const Pointer &pointer = settings.pointer;
  const Rectangle pixel{pixel_at(pointer.x * width, width), pixel_at(pointer.y * height, height), 1,
                        1};
  const std::optional<Rectangle> marked =
      haptic::marked_object_at(buffer, pixel.x, pixel.y, width, height);
  const std::optional<Rectangle> before = std::exchange(state.object, std::nullopt);
  if (!marked)
    return std::nullopt;
  // Of a long one too: the tracker needs some pixels across, of a region reduced to 128 px.
  constexpr int kLongest = 8; // times as long as wide
  const int longest = kLongest * std::min(marked->width, marked->height);
  const Rectangle near = haptic::region_at(
      pointer.x, pointer.y, std::min({width / 2, height / 2, longest}), width, height);
  const Rectangle shown = haptic::intersection(*marked, near);
  Rectangle object = steadied(shown, before, width, height);
  if (haptic::intersection(object, pixel) != pixel)
    object = shown;
  if (haptic::is_measurable(object))
    state.object = object;
  return state.object;
}

Rectangle region_of(State &state, const GstVideoInfo &info, const Settings &settings,
                    const std::optional<Rectangle> &object) {
  const int width = GST_VIDEO_INFO_WIDTH(&info);
  const int height = GST_VIDEO_INFO_HEIGHT(&info);
  const int base = settings.roi_size > 0 ? static_cast<int>(settings.roi_size)
                                         : haptic::default_region_side(width);
  const int side = state.region_size.side(settings.pointer.z, base, width, height);
  const haptic::HeldReport &held = state.thing.report();
  if (!haptic::is_followed(held.state))
    return object ? *object
                  : haptic::region_at(settings.pointer.x, settings.pointer.y, side, width, height);
  if (!state.taken_object)
    return haptic::region_at(held.x / static_cast<float>(width),
                             held.y / static_cast<float>(height), side, width, height);
  Rectangle region = *state.taken_object;
  region.x += pixel_at(static_cast<double>(held.x), width);
  region.y += pixel_at(static_cast<double>(held.y), height);
  return haptic::crop_around(region, 0, width, height);
}

// Holding

// How long after the reference a frame comes that cannot be compared with it, since frames between
// them were dropped. Nothing: it may be of another scene.
std::optional<GstClockTime> gap_before(const State &state, GstClockTime now) {
  constexpr auto kLongest = static_cast<GstClockTimeDiff>(GST_SECOND);
  if (!state.reference || !GST_CLOCK_TIME_IS_VALID(now))
    return std::nullopt;
  const GstClockTimeDiff gap =
      std::abs(GST_CLOCK_DIFF(GST_BUFFER_PTS(state.reference.get()), now)); // it may run backwards
  return gap <= kLongest ? std::optional(static_cast<GstClockTime>(gap)) : std::nullopt;
}

// Follows the thing into this frame, after the motion of the region was measured.
void follow_thing(State &state, const haptic::FrameLuma &luma, const Finding &finding,
                  GstClockTime now) {
  const bool is_compared = (finding.flags & haptic::kMotionDiscontinuity) == 0;
  const auto interval = is_compared ? std::optional(finding.interval) : gap_before(state, now);
  if ((finding.flags & haptic::kMotionCut) != 0 || !interval) {
    state.thing.lose();
    return;
  }
  const float seconds = static_cast<float>(*interval) / static_cast<float>(GST_SECOND);
  if ((finding.flags & haptic::kMotionStill) != 0)
    state.thing.rest(luma, seconds);
  else if (finding.becomes_reference && seconds > 0)
    state.thing.follow(luma, seconds);
}

// Takes, follows or releases the thing. False: the frame cannot be read.
bool hold(GstRoiTracker *self, GstBuffer *buffer, const Settings &settings, const Finding &finding,
          const std::optional<Rectangle> &object) {
  State &state = *self->state;
  if (!settings.holds) {
    state.release();
    return true;
  }
  const bool was_pressed = std::exchange(state.was_pressed, true);
  const GstVideoInfo &info = GST_VIDEO_FILTER(self)->in_info;
  const MappedFrame frame(info, buffer);
  if (!frame)
    return false;
  const haptic::FrameLuma luma(frame.frame());
  const GstClockTime now = GST_BUFFER_PTS(buffer);
  if (was_pressed) {
    // Not the sum of the intervals: those of repeated frames overlap.
    if (GST_CLOCK_TIME_IS_VALID(now)) {
      if (!GST_CLOCK_TIME_IS_VALID(state.taken))
        state.taken = now;
      state.held_time = now > state.taken ? now - state.taken : state.taken - now;
    }
    follow_thing(state, luma, finding, now);
    return true;
  }
  const int width = GST_VIDEO_INFO_WIDTH(&info);
  const int height = GST_VIDEO_INFO_HEIGHT(&info);
  state.held_time = 0;
  state.taken = now;
  const float x = static_cast<float>(settings.pointer.x) * static_cast<float>(width);
  const float y = static_cast<float>(settings.pointer.y) * static_cast<float>(height);
  state.thing.take(luma, width, height, x, y, object);
  state.taken_object = object;
  if (object) {
    state.taken_object->x -= pixel_at(static_cast<double>(x), width);
    state.taken_object->y -= pixel_at(static_cast<double>(y), height);
  }
  return true;
}

struct FeltPatches {
  std::span<const haptic::Patch> patches;
  int candidates = 0;
};

// Those of the region until the thing is taken and while it is followed about, else the thing
// itself, for which there is room in `of_thing`, or none.
FeltPatches felt_patches(const State &state, haptic::Patch &of_thing) {
  const haptic::HeldReport &held = state.thing.report();
  const bool is_taken = held.state == HoldState::held && state.held_time == 0;
  if (is_taken || held.state == HoldState::none || held.state == HoldState::about)
    return {state.tracker.measurement().view(), state.tracker.measurement().candidates};
  if (held.state != HoldState::held || !(held.variance > 0))
    return {{}, 1};
  const float precision = 1 / held.variance;
  of_thing = {.x = held.x - held.dx,
              .y = held.y - held.dy,
              .width = 2 * held.radius,
              .height = 2 * held.radius,
              .dx = held.dx,
              .dy = held.dy,
              .precision_xx = precision,
              .precision_xy = 0,
              .precision_yy = precision,
              .residual = 0,
              .share = 0};
  return {{&of_thing, 1}, 1};
}

// Keeps the frame for the comparison with the next one.
void keep_reference(State &state, GstBuffer *buffer) {
  if (!GST_BUFFER_PTS_IS_VALID(buffer)) {
    state.reference.reset();
    return;
  }
  state.timeline.adopt();
  state.reference.reset(gst_buffer_ref(buffer));
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

const GstHapticMotionMeta &attach_motion(GstRoiTracker *self, GstBuffer *buffer,
                                         const Rectangle &region, const Settings &settings,
                                         const Finding &finding) {
  const GstVideoInfo &info = GST_VIDEO_FILTER(self)->in_info;
  haptic::Patch of_thing;
  const FeltPatches felt = felt_patches(*self->state, of_thing);
  GstHapticMotionMeta *meta = gst_buffer_get_haptic_motion_meta(buffer);
  if (meta)
    gst_buffer_remove_meta(buffer, &meta->meta);
  meta = gst_buffer_add_haptic_motion_meta(buffer);
  meta->flags = finding.flags;
  if (felt.patches.data() == &of_thing) // which is no tile of the region
    meta->flags &= ~static_cast<guint>(GST_HAPTIC_MOTION_TILED);
  meta->frame_width = static_cast<guint>(GST_VIDEO_INFO_WIDTH(&info));
  meta->frame_height = static_cast<guint>(GST_VIDEO_INFO_HEIGHT(&info));
  meta->region_x = static_cast<gfloat>(region.x);
  meta->region_y = static_cast<gfloat>(region.y);
  meta->region_width = static_cast<gfloat>(region.width);
  meta->region_height = static_cast<gfloat>(region.height);
  meta->pointer_x = static_cast<gfloat>(settings.pointer.x * GST_VIDEO_INFO_WIDTH(&info));
  meta->pointer_y = static_cast<gfloat>(settings.pointer.y * GST_VIDEO_INFO_HEIGHT(&info));
  meta->interval = finding.interval;
  meta->n_candidates = static_cast<guint>(felt.candidates);
  meta->n_patches = static_cast<guint>(felt.patches.size());
  std::ranges::copy(felt.patches, meta->patches);
  if (settings.force) {
    meta->force_x = static_cast<gfloat>((*settings.force)[0]);
    meta->force_y = static_cast<gfloat>((*settings.force)[1]);
    meta->force_z = static_cast<gfloat>((*settings.force)[2]);
  }
  if (settings.proxy) {
    meta->proxy_x = static_cast<gfloat>(settings.proxy->x * GST_VIDEO_INFO_WIDTH(&info));
    meta->proxy_y = static_cast<gfloat>(settings.proxy->y * GST_VIDEO_INFO_HEIGHT(&info));
    meta->depth = static_cast<gfloat>(settings.proxy->depth);
  }
  const haptic::HeldReport &held = self->state->thing.report();
  if (held.state != HoldState::none) {
    meta->hold = static_cast<guint>(held.state);
    meta->held_x = held.x;
    meta->held_y = held.y;
    meta->held_radius = held.radius;
    meta->held_time = self->state->held_time;
  }
  return *meta;
}

// For readers without the header of the metadata. `motion` becomes a parameter of the region.
void attach_region(GstBuffer *buffer, const Rectangle &region, GstStructure *motion) {
  static const GQuark kRoiType = g_quark_from_static_string("haptic-roi");
  remove_metas(buffer, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE, [](GstMeta *other) {
    return reinterpret_cast<GstVideoRegionOfInterestMeta *>(other)->roi_type == kRoiType;
  });
  gst_video_region_of_interest_meta_add_param(
      gst_buffer_add_video_region_of_interest_meta_id(
          buffer, kRoiType, static_cast<guint>(region.x), static_cast<guint>(region.y),
          static_cast<guint>(region.width), static_cast<guint>(region.height)),
      motion);
}

// Call it without a lock: handlers may call anything.
void notify_pointer(GstRoiTracker *self, const Pointer &pointer) {
  const Pointer before = std::exchange(self->state->notified_pointer, pointer);
  if (pointer.x != before.x)
    g_object_notify(G_OBJECT(self), "pointer-x");
  if (pointer.y != before.y)
    g_object_notify(G_OBJECT(self), "pointer-y");
}

// Streaming

Settings current_settings(GstRoiTracker *self) {
  const ObjectLock lock(self);
  Shared &shared = self->state->shared;
  const auto now = Clock::now();
  return {shared.pointers.in_use(now),
          shared.pointers.force(now),
          shared.pointers.proxy(now),
          shared.roi_size,
          shared.max_points,
          shared.method,
          shared.region,
          holds(shared, now),
          std::exchange(shared.let_go, false)};
}

GstFlowReturn transform_ip(GstRoiTracker *self, GstBuffer *buffer) {
  State &state = *self->state;
  haptic::sync_controllers(self, GST_BASE_TRANSFORM(self)->segment, buffer);
  const Settings settings = current_settings(self);
  if (settings.let_go)
    state.release();
  const GstVideoInfo &info = GST_VIDEO_FILTER(self)->in_info;
  const std::optional<Rectangle> object = object_under_pointer(state, buffer, info, settings);
  const Rectangle region = region_of(state, info, settings, object);
  const std::optional<Finding> finding = measure(self, buffer, region, settings);
  if (!finding || !hold(self, buffer, settings, *finding, object)) {
    GST_ELEMENT_ERROR(self, STREAM, FORMAT, (messages::kUnreadableFrame),
                      ("%" GST_PTR_FORMAT, static_cast<void *>(buffer)));
    return GST_FLOW_ERROR;
  }
  const GstHapticMotionMeta &meta = attach_motion(self, buffer, region, settings, *finding);
  GstStructure *motion = gst_structure_new_empty("haptic-motion");
  haptic::set_motion(motion, state.reader.read(meta, info));
  attach_region(buffer, region, motion);
  state.analytics.attach(buffer, meta);
  if (finding->becomes_reference)
    keep_reference(state, buffer);
  const haptic::Measurement &measurement = state.tracker.measurement();
  {
    const ObjectLock lock(self);
    state.shared.statistics.add(*finding, measurement.count);
  }
  notify_pointer(self, settings.pointer);
  GST_LOG_OBJECT(self, "region %dx%d+%d+%d, %d of %d patches, flags %x", region.width,
                 region.height, region.x, region.y, measurement.count, measurement.candidates,
                 finding->flags);
  return GST_FLOW_OK;
}

// The stream may have begun: the pad takes events and buffers before this call.
gboolean start(GstRoiTracker *self) {
  const ObjectLock lock(self);
  self->state->shared.statistics = {};
  return TRUE;
}

gboolean stop(GstRoiTracker *self) {
  const haptic::StreamLock stream(self);
  State &state = *self->state;
  state.forget_frames();
  state.region_size = {};
  state.object.reset();
  state.release();
  state.timeline.report_faults_again();
  state.reader = {};
  state.warned_of_tracker = false;
  const ObjectLock lock(self);
  state.shared.pointers.forget();
  state.shared.let_go = false;
  state.shared.finger.reset();
  state.shared.frame_width = 0;
  state.shared.frame_height = 0;
  return TRUE;
}

gboolean set_info(GstRoiTracker *self, GstCaps *, GstVideoInfo *info) {
  State &state = *self->state;
  state.forget_frames();
  const ObjectLock lock(self);
  state.shared.frame_width = GST_VIDEO_INFO_WIDTH(info);
  state.shared.frame_height = GST_VIDEO_INFO_HEIGHT(info);
  return TRUE;
}

// Events and queries

void post_statistics(GstRoiTracker *self) {
  const auto statistics = haptic::locked_copy(self, self->state->shared.statistics);
  gst_element_post_message(GST_ELEMENT(self),
                           gst_message_new_element(GST_OBJECT(self), to_structure(statistics)));
}

// The event that says that the finger or the button was lifted may have been lost while pads were
// flushing.
void let_go(GstRoiTracker *self) {
  const ObjectLock lock(self);
  Shared &shared = self->state->shared;
  shared.finger.reset();
  change_hold(shared, [&] { shared.pointers.press_navigation(false); });
}

void on_sink_event(GstRoiTracker *self, GstEvent *event) {
  switch (GST_EVENT_TYPE(event)) {
  case GST_EVENT_FLUSH_STOP:
    let_go(self);
    [[fallthrough]];
  case GST_EVENT_SEGMENT:
    self->state->forget_frames();
    break;
  case GST_EVENT_EOS:
    post_statistics(self);
    break;
  default:
    break;
  }
}

// Of several fingers the first points. Returns whether the event is of another one.
bool is_of_another_finger(Shared &shared, GstEvent *event) {
  guint finger = 0;
  const GstNavigationEventType type = gst_navigation_event_get_type(event);
  if (type == GST_NAVIGATION_EVENT_TOUCH_UP)
    gst_navigation_event_parse_touch_up_event(event, &finger, nullptr, nullptr);
  else if (type == GST_NAVIGATION_EVENT_TOUCH_DOWN || type == GST_NAVIGATION_EVENT_TOUCH_MOTION)
    gst_navigation_event_parse_touch_event(event, &finger, nullptr, nullptr, nullptr);
  else {
    if (type == GST_NAVIGATION_EVENT_TOUCH_CANCEL)
      shared.finger.reset(); // of all fingers
    return false;
  }
  // One that only moves did not point, and does not begin to.
  if (shared.finger ? *shared.finger != finger : type != GST_NAVIGATION_EVENT_TOUCH_DOWN)
    return true;
  shared.finger = finger;
  if (type == GST_NAVIGATION_EVENT_TOUCH_UP)
    shared.finger.reset();
  return false;
}

// What an event says about the button or the finger that points.
std::optional<bool> press_of(GstEvent *event) {
  constexpr gint kFirstButton = 1;
  gint button = 0;
  switch (gst_navigation_event_get_type(event)) {
  case GST_NAVIGATION_EVENT_MOUSE_BUTTON_PRESS:
  case GST_NAVIGATION_EVENT_MOUSE_BUTTON_RELEASE:
    gst_navigation_event_parse_mouse_button_event(event, &button, nullptr, nullptr);
    if (button != kFirstButton)
      return std::nullopt;
    return gst_navigation_event_get_type(event) == GST_NAVIGATION_EVENT_MOUSE_BUTTON_PRESS;
  case GST_NAVIGATION_EVENT_TOUCH_DOWN:
    return true;
  case GST_NAVIGATION_EVENT_TOUCH_UP:
  case GST_NAVIGATION_EVENT_TOUCH_CANCEL:
    return false;
  default:
    return std::nullopt;
  }
}

void on_navigation(GstRoiTracker *self, GstEvent *event) {
  const ObjectLock lock(self);
  Shared &shared = self->state->shared;
  if (shared.frame_width == 0 || is_of_another_finger(shared, event))
    return;
  gdouble x = 0;
  gdouble y = 0;
  if (gst_navigation_event_get_coordinates(event, &x, &y) && std::isfinite(x) && std::isfinite(y))
    shared.pointers.point_navigation(x, y, shared.frame_width, shared.frame_height);
  if (const std::optional<bool> pressed = press_of(event))
    change_hold(shared, [&] { shared.pointers.press_navigation(*pressed); });
}

// Returns whether the event ends here.
bool on_src_event(GstRoiTracker *self, GstEvent *event) {
  // A late window would make the decoder skip frames, and each skipped frame is a discontinuity of
  // the motion.
  if (GST_EVENT_TYPE(event) == GST_EVENT_QOS)
    return true;
  if (GST_EVENT_TYPE(event) == GST_EVENT_NAVIGATION)
    on_navigation(self, event);
  const auto position = haptic::parse_pointer_event(event);
  if (!position)
    return false;
  const ObjectLock lock(self);
  Shared &shared = self->state->shared;
  change_hold(shared, [&] {
    shared.pointers.point_haptic({position->x, position->y, position->z, position->pressed},
                                 Clock::now(), position->force, position->proxy, position->device);
  });
  return true;
}

// Frames pass through, so the query goes downstream. The reference holds one buffer more. Pixels
// that only downstream would crop would be measured.
gboolean propose_allocation(GstBaseTransform *trans, GstQuery *, GstQuery *query) {
  constexpr guint kHeld = 1;
  GstCaps *caps = nullptr;
  gst_query_parse_allocation(query, &caps, nullptr);
  GstVideoInfo info;
  if (!caps || !gst_video_info_from_caps(&info, caps))
    return FALSE;
  if (!gst_pad_peer_query(GST_BASE_TRANSFORM_SRC_PAD(trans), query))
    GST_DEBUG_OBJECT(trans, "downstream does not answer the ALLOCATION query");
  guint crop = 0;
  while (gst_query_find_allocation_meta(query, GST_VIDEO_CROP_META_API_TYPE, &crop))
    gst_query_remove_nth_allocation_meta(query, crop);

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

} // namespace

static void install_transform_vfuncs(GstBaseTransformClass *klass) {
  // Without it the base class works in place only; GstVideoFilter's own transform_ip would map the
  // pixels for writing, and copy them.
  klass->transform = nullptr;
  klass->transform_ip = kGuarded<transform_ip>;
  klass->prepare_output_buffer = [](GstBaseTransform *trans, GstBuffer *in, GstBuffer **out) {
    return guarded(trans, GST_FLOW_ERROR, [&] {
      *out = haptic::with_own_metadata(in);
      return *out ? GST_FLOW_OK : GST_FLOW_ERROR;
    });
  };
  klass->sink_event = [](GstBaseTransform *trans, GstEvent *event) {
    guarded(trans, [&] { on_sink_event(GST_ROI_TRACKER(trans), event); });
    return GST_BASE_TRANSFORM_CLASS(gst_roi_tracker_parent_class)->sink_event(trans, event);
  };
  klass->src_event = [](GstBaseTransform *trans, GstEvent *event) -> gboolean {
    if (!guarded(trans, false, [&] { return on_src_event(GST_ROI_TRACKER(trans), event); }))
      return GST_BASE_TRANSFORM_CLASS(gst_roi_tracker_parent_class)->src_event(trans, event);
    gst_event_unref(event);
    return TRUE;
  };
  klass->query = [](GstBaseTransform *trans, GstPadDirection direction, GstQuery *query) {
    // Upstream wants every buffer back, the reference too. Serialised with the frames.
    if (GST_QUERY_TYPE(query) == GST_QUERY_DRAIN && direction == GST_PAD_SINK)
      guarded(trans, [&] { GST_ROI_TRACKER(trans)->state->forget_frames(); });
    return GST_BASE_TRANSFORM_CLASS(gst_roi_tracker_parent_class)->query(trans, direction, query);
  };
  klass->propose_allocation = kGuarded<propose_allocation>;
  klass->start = kGuarded<start>;
  klass->stop = kGuarded<stop>;
}

static void gst_roi_tracker_class_init(GstRoiTrackerClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  haptic::describe(element_class, "roitracker", "Region of interest tracker",
                   "Filter/Analyzer/Video",
                   "Measures the motion under a pointer and attaches it to the untouched frame",
                   ROITRACKER_CAPS, ROITRACKER_CAPS);

  auto *object_class = G_OBJECT_CLASS(klass);
  object_class->finalize = haptic::delete_state<GstRoiTracker, gst_roi_tracker_parent_class>;
  haptic::install_properties<properties>(object_class, [](GObject *object) -> Shared & {
    return GST_ROI_TRACKER(object)->state->shared;
  });
  install_transform_vfuncs(GST_BASE_TRANSFORM_CLASS(klass));
  GST_VIDEO_FILTER_CLASS(klass)->set_info = kGuarded<set_info>;
}

static void gst_roi_tracker_init(GstRoiTracker *self) {
  self->state = new State;
  haptic::keep_every_frame(GST_BASE_TRANSFORM(self));
}
