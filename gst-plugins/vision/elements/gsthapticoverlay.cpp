// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticoverlay draws over a frame the motion that was measured in it, the force that the hand
// feels, the relief that it touches and the thing that it holds.
//
//   gst-launch-1.0 videotestsrc ! roitracker ! hapticoverlay ! videoconvert ! autovideosink
//
// It draws on a writable frame in place, lets downstream draw where downstream can, and copies a
// frame only where neither is possible.
#include "elements/average-types.hpp"
#include "elements/motion-reader.hpp"
#include "frames/frame-caps.hpp"
#include "frames/luma-crop.hpp"
#include "frames/mapped-frame.hpp"
#include "glue/controllers.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/property-table.hpp"
#include "glue/relief-pad.hpp"
#include "glue/segment-time.hpp"
#include "glue/stream-lock.hpp"
#include "gsthapticmotionmeta.h"
#include "messages.hpp"
#include "overlay/frame-blending.hpp"
#include "overlay/overlay-drawing.hpp"
#include "overlay/shown-relief.hpp"
#include "overlay/touch-picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gst/video/gstvideofilter.h>
#include <optional>
#include <span>
#include <utility>

G_DECLARE_FINAL_TYPE(GstHapticOverlay, gst_haptic_overlay, GST, HAPTIC_OVERLAY, GstVideoFilter)

GST_DEBUG_CATEGORY_STATIC(haptic_overlay_debug);
#define GST_CAT_DEFAULT haptic_overlay_debug

namespace {

using haptic::kGuarded;
using haptic::MappedFrame;
using haptic::OverlayLook;
using haptic::OverlayPixels;
using haptic::OverlayStyle;

// State

struct Settings : OverlayLook {
  // As of the velocityavg whose output is felt: it is on another branch.
  haptic::Average average = haptic::kUsualAverage;
  haptic::ModelChoice motion_model = haptic::ModelChoice::automatic;
  double deform = 0;    // px of pull per mm of depth
  double shading = 0.5; // 0..1
};

// What a frame gets. The overlay is drawn last.
struct Changes {
  bool shaded = false;
  haptic::Dent dent;
  std::optional<OverlayPixels> drawn;

  bool of_pixels() const { return shaded || dent.pull > 0; }
};

struct State {
  // Object lock: written by the application, read by the streaming thread.
  Settings settings;

  // Streaming thread only, or while it is stopped.
  haptic::MotionReader reader;
  haptic::HeldTrail trail;
  bool attaches = false; // downstream draws the overlay
  Changes changes;       // of the frame under way
  haptic::DentPainter dents;
  haptic::ReliefShading shading;

  haptic::ShownRelief relief;      // has its own lock
  haptic::RequestedPad relief_pad; // the same
};

} // namespace

struct _GstHapticOverlay {
  GstVideoFilter parent;
  State *state; // made in _init, deleted in _finalize
};

G_DEFINE_TYPE_WITH_CODE(GstHapticOverlay, gst_haptic_overlay, GST_TYPE_VIDEO_FILTER,
                        GST_DEBUG_CATEGORY_INIT(haptic_overlay_debug, "hapticoverlay", 0,
                                                "what is felt, drawn over the frame"))
GST_ELEMENT_REGISTER_DEFINE(hapticoverlay, "hapticoverlay", GST_RANK_NONE,
                            gst_haptic_overlay_get_type())

namespace {

// Properties

std::span<const haptic::Property<Settings>> properties() {
  using Rows = haptic::Rows<Settings>;
  constexpr double kLongestScale = 10; // s
  constexpr double kMostDeform = 100;  // px/mm
  static const haptic::Property<Settings> table[] = {
      Rows::choice<&Settings::style>(
          "style", "Style", "What is drawn",
          haptic::register_enum<OverlayStyle>(
              "GstHapticOverlayStyle",
              {{OverlayStyle::none, "Nothing", "none"},
               {OverlayStyle::arrows, "Region, velocity, force and held thing", "arrows"},
               {OverlayStyle::full,
                "These, the displacement of each patch, the motion model and the confidence",
                "full"}})),
      Rows::number<&Settings::velocity_color>("velocity-color", "Velocity Color",
                                              "Of velocity and patches, ARGB", 0, G_MAXUINT32),
      Rows::number<&Settings::force_color>("force-color", "Force Color", "Of the force, ARGB", 0,
                                           G_MAXUINT32),
      Rows::number<&Settings::hold_color>(
          "hold-color", "Hold Color", "Of the held thing and of a contact, ARGB", 0, G_MAXUINT32),
      Rows::number<&Settings::scale>(
          "scale", "Scale",
          "Seconds of motion that an arrow is long; none is longer than half of the frame's height",
          0, kLongestScale, haptic::kControllable),
      Rows::choice<&Settings::average>("average", "Average",
                                       "That of the velocityavg whose output is felt",
                                       haptic::average_type()),
      Rows::choice<&Settings::motion_model>("motion-model", "Motion Model",
                                            "That of the velocityavg whose output is felt",
                                            haptic::motion_model_type()),
      Rows::number<&Settings::deform>("deform", "Deform",
                                      "Pixels that the picture is pulled towards a touching hand "
                                      "per mm of depth; 0: not at all",
                                      0, kMostDeform, haptic::kControllable),
      Rows::number<&Settings::shading>(
          "shading", "Shading", "Strength of the light on the relief of the pad relief; 0: none", 0,
          1, haptic::kControllable),
  };
  return table;
}

// Drawing

std::string label_of(const haptic::MotionSample &sample) {
  const std::string model(haptic::motion_model_name(sample.model));
  char number[8];
  std::snprintf(number, sizeof number, "%.2f", static_cast<double>(sample.confidence));
  return model + ' ' + number;
}

haptic::OverlayScene scene_of(const GstHapticMotionMeta &meta, const haptic::MotionSample &sample,
                              const haptic::HeldTrail &trail) {
  const bool is_held = haptic::is_followed(sample.held.state);
  haptic::OverlayScene scene{
      .frame_width = static_cast<int>(sample.frame_width),
      .frame_height = static_cast<int>(sample.frame_height),
      .pixel_aspect = static_cast<double>(sample.pixel_aspect_n) / sample.pixel_aspect_d,
      .region_x = static_cast<double>(meta.region_x),
      .region_y = static_cast<double>(meta.region_y),
      .region_width = static_cast<double>(meta.region_width),
      .region_height = static_cast<double>(meta.region_height),
      .pointer_x = static_cast<double>(is_held ? meta.held_x : meta.pointer_x),
      .pointer_y = static_cast<double>(is_held ? meta.held_y : meta.pointer_y),
      .velocity_x = static_cast<double>(sample.velocity_x),
      .velocity_y = static_cast<double>(sample.velocity_y),
      .confidence = static_cast<double>(sample.confidence),
      .label = label_of(sample),
      .patches = std::span(meta.patches)
                     .first(std::min<std::size_t>(meta.n_patches, std::size(meta.patches))),
      .interval = static_cast<double>(meta.interval) / GST_SECOND,
      .held = sample.held,
      .trail = trail.points(),
  };
  if (std::isfinite(meta.force_x) && std::isfinite(meta.force_y))
    scene.force = {static_cast<double>(meta.force_x), static_cast<double>(meta.force_y)};
  if (meta.depth >= 0) { // not NaN
    scene.proxy = {static_cast<double>(meta.proxy_x), static_cast<double>(meta.proxy_y)};
    scene.touches = meta.depth > 0;
  }
  return scene;
}

// Returns the overlay of a frame, or nothing if there is nothing to draw.
std::optional<OverlayPixels> overlay_of(GstHapticOverlay *self, const GstHapticMotionMeta &meta,
                                        const Settings &settings) {
  State &state = *self->state;
  const haptic::MotionSample sample = state.reader.read(meta, GST_VIDEO_FILTER(self)->in_info,
                                                        settings.average, settings.motion_model);
  state.trail.add(sample.held);
  const bool has_something =
      sample.confidence > 0 || meta.depth >= 0 || sample.held.state != haptic::HoldState::none;
  if (settings.style == OverlayStyle::none || !has_something)
    return std::nullopt;
  const haptic::OverlayDrawing drawing(scene_of(meta, sample, state.trail), settings);
  if (drawing.extent().width == 0)
    return std::nullopt;
  return haptic::paint(drawing);
}

Changes changes_of(GstHapticOverlay *self, GstBuffer *frame) {
  State &state = *self->state;
  const GstVideoInfo &info = GST_VIDEO_FILTER(self)->in_info;
  const Settings settings = haptic::locked_copy(self, state.settings);
  Changes changes;
  if (settings.shading > 0)
    changes.shaded = state.relief.read_at(
        haptic::running_time_of(GST_BASE_TRANSFORM(self)->segment, GST_BUFFER_PTS(frame)),
        [&](const haptic::ReliefField &relief) { state.shading.read(relief, settings.shading); });
  const GstHapticMotionMeta *meta = gst_buffer_get_haptic_motion_meta(frame);
  if (!meta) {
    state.reader.read_nothing(info);
    state.trail.forget();
    return changes;
  }
  if (meta->depth > 0)
    changes.dent = haptic::dent_at(
        static_cast<double>(meta->proxy_x), static_cast<double>(meta->proxy_y),
        static_cast<double>(meta->depth), settings.deform, GST_VIDEO_INFO_HEIGHT(&info));
  changes.drawn = overlay_of(self, *meta, settings);
  return changes;
}

// Streaming

GstFlowReturn prepare_output_buffer(GstHapticOverlay *self, GstBuffer *in, GstBuffer **out) {
  State &state = *self->state;
  haptic::sync_controllers(self, GST_BASE_TRANSFORM(self)->segment, in);
  state.changes = changes_of(self, in);
  const bool changes_pixels = state.changes.of_pixels();
  if ((!changes_pixels && !state.changes.drawn) ||
      (gst_buffer_is_writable(in) && gst_buffer_is_all_memory_writable(in))) {
    *out = in;
    return GST_FLOW_OK;
  }
  if (state.attaches && !changes_pixels) {
    *out = haptic::with_own_metadata(in);
    return *out ? GST_FLOW_OK : GST_FLOW_ERROR;
  }
  // The tracker and others behind the tee go on reading this frame: draw on a copy.
  return GST_BASE_TRANSFORM_CLASS(gst_haptic_overlay_parent_class)
      ->prepare_output_buffer(GST_BASE_TRANSFORM(self), in, out);
}

// Returns false if a buffer does not hold a frame of this format.
bool change_pixels(GstHapticOverlay *self, const Changes &changes, GstBuffer *in, GstBuffer *out) {
  State &state = *self->state;
  const GstVideoInfo &info = GST_VIDEO_FILTER(self)->out_info;
  MappedFrame frame(info, out, GST_MAP_READWRITE);
  if (!frame)
    return false;
  if (in != out) {
    const MappedFrame original(info, in);
    if (!original || !haptic::copy_pixels(original.frame(), frame.frame()))
      return false;
  }
  if (changes.shaded)
    state.shading.paint(frame.frame());
  state.dents.paint(changes.dent, frame.frame());
  return state.attaches || !changes.drawn || haptic::blend(*changes.drawn, frame.frame());
}

GstFlowReturn transform(GstHapticOverlay *self, GstBuffer *in, GstBuffer *out) {
  State &state = *self->state;
  const Changes changes = std::exchange(state.changes, {});
  const bool blends = changes.drawn && !state.attaches;
  if ((changes.of_pixels() || blends) && !change_pixels(self, changes, in, out)) {
    GST_ELEMENT_ERROR(self, STREAM, FORMAT, (haptic::messages::kUndrawableFrame),
                      ("%" GST_PTR_FORMAT, static_cast<void *>(in)));
    return GST_FLOW_ERROR;
  }
  if (changes.drawn && state.attaches)
    gst_buffer_add_video_overlay_composition_meta(
        out,
        haptic::compose(*changes.drawn, changes.drawn->extent.x, changes.drawn->extent.y).get());
  return GST_FLOW_OK;
}

// Caps and allocation

haptic::CapsPtr with_composition(const GstCaps *caps) {
  haptic::CapsPtr result(gst_caps_copy(caps));
  for (guint i = 0; i < gst_caps_get_size(result.get()); ++i)
    gst_caps_features_add(gst_caps_get_features(result.get(), i),
                          GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION);
  return result;
}

haptic::CapsPtr without_composition(const GstCaps *caps) {
  haptic::CapsPtr result(gst_caps_copy(caps));
  for (guint i = 0; i < gst_caps_get_size(result.get()); ++i)
    gst_caps_features_remove(gst_caps_get_features(result.get(), i),
                             GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION);
  return result;
}

// The caps with which downstream draws come first: they avoid a copy.
GstCaps *transform_caps(GstHapticOverlay *, GstPadDirection direction, GstCaps *caps,
                        GstCaps *filter) {
  haptic::CapsPtr result = without_composition(caps);
  if (direction == GST_PAD_SINK) {
    haptic::CapsPtr preferred = with_composition(result.get());
    result.reset(gst_caps_merge(preferred.release(), result.release()));
  }
  if (filter)
    result.reset(gst_caps_intersect_full(filter, result.get(), GST_CAPS_INTERSECT_FIRST));
  return result.release();
}

gboolean set_caps(GstBaseTransform *trans, GstCaps *in, GstCaps *out) {
  const gboolean result =
      GST_BASE_TRANSFORM_CLASS(gst_haptic_overlay_parent_class)->set_caps(trans, in, out);
  // The parent says that frames are changed in place; but copies then come from no pool.
  gst_base_transform_set_in_place(trans, FALSE);
  GST_HAPTIC_OVERLAY(trans)->state->trail.forget();
  return result;
}

gboolean sink_event(GstBaseTransform *trans, GstEvent *event) {
  if (GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT || GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP)
    GST_HAPTIC_OVERLAY(trans)->state->trail.forget();
  return GST_BASE_TRANSFORM_CLASS(gst_haptic_overlay_parent_class)->sink_event(trans, event);
}

GstPad *request_pad(GstElement *element, GstPadTemplate *of) {
  State &state = *GST_HAPTIC_OVERLAY(element)->state;
  return state.relief_pad.request(
      element, [&] { return haptic::add_shown_relief_pad(element, of, state.relief); });
}

void release_pad(GstElement *element, GstPad *pad) {
  gst_pad_set_active(pad, FALSE);
  gst_element_remove_pad(element, pad);
  GST_HAPTIC_OVERLAY(element)->state->relief_pad.released();
}

gboolean decide_allocation(GstBaseTransform *trans, GstQuery *query) {
  GstCaps *caps = nullptr;
  gst_query_parse_allocation(query, &caps, nullptr);
  GST_HAPTIC_OVERLAY(trans)->state->attaches =
      caps &&
      gst_caps_features_contains(gst_caps_get_features(caps, 0),
                                 GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION) &&
      gst_query_find_allocation_meta(query, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
  return GST_BASE_TRANSFORM_CLASS(gst_haptic_overlay_parent_class)->decide_allocation(trans, query);
}

} // namespace

static void gst_haptic_overlay_class_init(GstHapticOverlayClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  haptic::describe(element_class, "hapticoverlay", "Haptic overlay", "Filter/Effect/Video",
                   "Draws over a frame the motion that was measured in it, its force, and what is "
                   "touched or held",
                   GST_VIDEO_CAPS_MAKE(HAPTIC_DRAWN_FORMATS),
                   GST_VIDEO_CAPS_MAKE_WITH_FEATURES(
                       GST_CAPS_FEATURE_MEMORY_SYSTEM_MEMORY
                       ", " GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION,
                       HAPTIC_DRAWN_FORMATS) ";" GST_VIDEO_CAPS_MAKE(HAPTIC_DRAWN_FORMATS));
  gst_element_class_add_pad_template(element_class, haptic::relief_pad_template());
  element_class->request_new_pad = kGuarded<request_pad>;
  element_class->release_pad = kGuarded<release_pad>;

  auto *object_class = G_OBJECT_CLASS(klass);
  object_class->finalize = haptic::delete_state<GstHapticOverlay, gst_haptic_overlay_parent_class>;
  haptic::install_properties<properties>(object_class, [](GObject *object) -> Settings & {
    return GST_HAPTIC_OVERLAY(object)->state->settings;
  });

  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);
  transform_class->transform_caps = kGuarded<transform_caps>;
  transform_class->set_caps = kGuarded<set_caps>;
  transform_class->sink_event = sink_event;
  transform_class->decide_allocation = kGuarded<decide_allocation>;
  transform_class->prepare_output_buffer = kGuarded<prepare_output_buffer>;
  // Not GstVideoFilter's own, which maps, and so copies, what is not drawn on.
  transform_class->transform = kGuarded<transform>;
  // The geometry stays as it is, so all metadata stay true.
  transform_class->transform_meta = [](GstBaseTransform *, GstBuffer *, GstMeta *,
                                       GstBuffer *) -> gboolean { return TRUE; };
  transform_class->start = kGuarded<[](GstHapticOverlay *self) {
    self->state->relief_pad.set_running(true);
    return TRUE;
  }>;
  transform_class->stop = kGuarded<[](GstHapticOverlay *self) {
    self->state->relief_pad.set_running(false);
    const haptic::StreamLock stream(self);
    self->state->reader = {};
    self->state->trail.forget();
    return TRUE;
  }>;
}

static void gst_haptic_overlay_init(GstHapticOverlay *self) {
  self->state = new State;
  // A frame skipped here would be missing from the history that a duplicate repeats.
  haptic::keep_every_frame(GST_BASE_TRANSFORM(self));
}
