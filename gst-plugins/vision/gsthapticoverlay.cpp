// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gsthapticoverlay.h"

#include "exception-barrier.hpp"
#include "gst-raii.hpp"
#include "gsthapticmotionmeta.h"
#include "luma-crop.hpp"
#include "mapped-frame.hpp"
#include "motion-reader.hpp"
#include "overlay-drawing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gst/video/video-overlay-composition.h>
#include <optional>
#include <utility>

GST_DEBUG_CATEGORY_STATIC(haptic_overlay_debug);
#define GST_CAT_DEFAULT haptic_overlay_debug

namespace {

using haptic::guarded;
using haptic::ObjectLock;
using haptic::OverlayLook;
using haptic::OverlayStyle;

enum PropertyId : guint { kStyle = 1, kVelocityColor, kForceColor, kScale };

constexpr double kLongestScale = 10; // s

struct CompositionUnref {
  void operator()(GstVideoOverlayComposition *composition) const {
    gst_video_overlay_composition_unref(composition);
  }
  void operator()(GstVideoOverlayRectangle *rectangle) const {
    gst_video_overlay_rectangle_unref(rectangle);
  }
};
using CompositionPtr = std::unique_ptr<GstVideoOverlayComposition, CompositionUnref>;
using RectanglePtr = std::unique_ptr<GstVideoOverlayRectangle, CompositionUnref>;

// What lies over a frame.
struct Drawn {
  haptic::BufferPtr pixels; // with its GstVideoMeta
  haptic::Rectangle extent;
};

struct State {
  // Object lock: written by the application, read by the streaming thread.
  OverlayLook look;

  // Streaming thread only, or while it is stopped.
  haptic::MotionReader reader;
  bool attaches = false;      // downstream draws it
  std::optional<Drawn> drawn; // over the frame under way
};

} // namespace

struct _GstHapticOverlay {
  GstVideoFilter parent;
  State *state; // made in _init, deleted in _finalize
};

static GstStaticPadTemplate sink_template =
    GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                            GST_STATIC_CAPS(GST_VIDEO_CAPS_MAKE(HAPTIC_VIDEO_FORMATS)));
static GstStaticPadTemplate src_template = GST_STATIC_PAD_TEMPLATE(
    "src", GST_PAD_SRC, GST_PAD_ALWAYS,
    GST_STATIC_CAPS(GST_VIDEO_CAPS_MAKE_WITH_FEATURES(
        GST_CAPS_FEATURE_MEMORY_SYSTEM_MEMORY
        ", " GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION,
        HAPTIC_VIDEO_FORMATS) ";" GST_VIDEO_CAPS_MAKE(HAPTIC_VIDEO_FORMATS)));

G_DEFINE_TYPE_WITH_CODE(GstHapticOverlay, gst_haptic_overlay, GST_TYPE_VIDEO_FILTER,
                        GST_DEBUG_CATEGORY_INIT(haptic_overlay_debug, "hapticoverlay", 0,
                                                "what is felt, drawn over the frame"))
GST_ELEMENT_REGISTER_DEFINE(hapticoverlay, "hapticoverlay", GST_RANK_NONE, GST_TYPE_HAPTIC_OVERLAY)

namespace {

GType style_type() {
  static const GEnumValue values[] = {
      {static_cast<int>(OverlayStyle::none), "Nothing", "none"},
      {static_cast<int>(OverlayStyle::arrows), "Region, velocity and force", "arrows"},
      {static_cast<int>(OverlayStyle::full),
       "These, the displacement of each patch, the motion model and the confidence", "full"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstHapticOverlayStyle", values);
  return type;
}

std::string label_of(const haptic::MotionSample &sample) {
  const std::string model(haptic::motion_model_name(sample.model));
  char number[8];
  std::snprintf(number, sizeof number, "%.2f", static_cast<double>(sample.confidence));
  return model + ' ' + number;
}

haptic::OverlayScene scene_of(const GstHapticMotionMeta &meta, const haptic::MotionSample &sample) {
  haptic::OverlayScene scene{
      .frame_width = static_cast<int>(sample.frame_width),
      .frame_height = static_cast<int>(sample.frame_height),
      .pixel_aspect = static_cast<double>(sample.pixel_aspect_n) / sample.pixel_aspect_d,
      .region_x = static_cast<double>(meta.region_x),
      .region_y = static_cast<double>(meta.region_y),
      .region_width = static_cast<double>(meta.region_width),
      .region_height = static_cast<double>(meta.region_height),
      .pointer_x = static_cast<double>(meta.pointer_x),
      .pointer_y = static_cast<double>(meta.pointer_y),
      .velocity_x = static_cast<double>(sample.velocity_x),
      .velocity_y = static_cast<double>(sample.velocity_y),
      .confidence = static_cast<double>(sample.confidence),
      .label = label_of(sample),
      .patches = std::span(meta.patches)
                     .first(std::min<std::size_t>(meta.n_patches, std::size(meta.patches))),
      .interval = static_cast<double>(meta.interval) / GST_SECOND,
  };
  if (std::isfinite(meta.force_x) && std::isfinite(meta.force_y))
    scene.force = {static_cast<double>(meta.force_x), static_cast<double>(meta.force_y)};
  return scene;
}

Drawn paint(const haptic::OverlayDrawing &drawing) {
  const haptic::Rectangle &extent = drawing.extent();
  const auto width = static_cast<guint>(extent.width);
  const auto height = static_cast<guint>(extent.height);
  const gsize stride = 4 * static_cast<gsize>(width);
  haptic::BufferPtr pixels(gst_buffer_new_allocate(nullptr, stride * height, nullptr));
  gst_buffer_add_video_meta(pixels.get(), GST_VIDEO_FRAME_FLAG_NONE,
                            GST_VIDEO_OVERLAY_COMPOSITION_FORMAT_RGB, width, height);
  GstMapInfo map;
  gst_buffer_map(pixels.get(), &map, GST_MAP_WRITE);
  std::fill_n(map.data, map.size, guint8{0});
  drawing.paint(map.data, static_cast<int>(stride));
  gst_buffer_unmap(pixels.get(), &map);
  return {std::move(pixels), extent};
}

// What lies over the frame; nothing, where nothing was measured.
std::optional<Drawn> look_at(GstHapticOverlay *self, GstBuffer *frame) {
  State &state = *self->state;
  const GstVideoInfo &info = GST_VIDEO_FILTER(self)->in_info;
  const GstHapticMotionMeta *meta = gst_buffer_get_haptic_motion_meta(frame);
  if (!meta) {
    state.reader.read_nothing(info);
    return std::nullopt;
  }
  const haptic::MotionSample sample = state.reader.read(*meta, info);
  OverlayLook look;
  {
    const ObjectLock lock(self);
    look = state.look;
  }
  if (!(sample.confidence > 0) || look.style == OverlayStyle::none)
    return std::nullopt;
  const haptic::OverlayDrawing drawing(scene_of(*meta, sample), look);
  if (drawing.extent().width == 0)
    return std::nullopt;
  return paint(drawing);
}

GstFlowReturn prepare(GstHapticOverlay *self, GstBuffer *in, GstBuffer **out) {
  State &state = *self->state;
  state.drawn = look_at(self, in);
  if (!state.drawn || (gst_buffer_is_writable(in) && gst_buffer_is_all_memory_writable(in))) {
    *out = in;
    return GST_FLOW_OK;
  }
  if (state.attaches) {
    *out = haptic::with_own_metadata(in);
    return *out ? GST_FLOW_OK : GST_FLOW_ERROR;
  }
  // The tracker and others behind the tee go on reading this frame: draw on a copy.
  return GST_BASE_TRANSFORM_CLASS(gst_haptic_overlay_parent_class)
      ->prepare_output_buffer(GST_BASE_TRANSFORM(self), in, out);
}

// With its top left corner there.
CompositionPtr compose(const Drawn &drawn, int x, int y) {
  const RectanglePtr rectangle(gst_video_overlay_rectangle_new_raw(
      drawn.pixels.get(), x, y, static_cast<guint>(drawn.extent.width),
      static_cast<guint>(drawn.extent.height), GST_VIDEO_OVERLAY_FORMAT_FLAG_PREMULTIPLIED_ALPHA));
  return CompositionPtr(gst_video_overlay_composition_new(rectangle.get()));
}

// A view of the part of a frame that holds a rectangle, whose place in it is left in `x` and `y`.
// Blending converts whole rows, so they had better be short.
GstVideoFrame part_of(const GstVideoFrame &frame, const haptic::Rectangle &rectangle, int &x,
                      int &y) {
  constexpr int kGrid = 2; // whole samples of chroma
  const int left = rectangle.x / kGrid * kGrid;
  const int top = rectangle.y / kGrid * kGrid;
  x = rectangle.x - left;
  y = rectangle.y - top;
  GstVideoFrame part = frame;
  part.info.width = std::min((x + rectangle.width + kGrid - 1) / kGrid * kGrid,
                             GST_VIDEO_FRAME_WIDTH(&frame) - left);
  part.info.height = std::min((y + rectangle.height + kGrid - 1) / kGrid * kGrid,
                              GST_VIDEO_FRAME_HEIGHT(&frame) - top);
  const GstVideoFormatInfo *format = frame.info.finfo;
  for (guint plane = 0; plane < GST_VIDEO_FRAME_N_PLANES(&frame); ++plane) {
    gint components[GST_VIDEO_MAX_COMPONENTS];
    gst_video_format_info_component(format, plane, components);
    const auto component = static_cast<guint>(components[0]);
    part.data[plane] = static_cast<guint8 *>(frame.data[plane]) +
                       GST_VIDEO_FORMAT_INFO_SCALE_HEIGHT(format, component, top) *
                           GST_VIDEO_FRAME_PLANE_STRIDE(&frame, plane) +
                       GST_VIDEO_FORMAT_INFO_SCALE_WIDTH(format, component, left) *
                           GST_VIDEO_FORMAT_INFO_PSTRIDE(format, component);
  }
  return part;
}

// gst_video_frame_copy() leaves out half of the last pair of pixels of YUY2 and UYVY of odd width.
GstVideoFrame whole_pairs(const GstVideoFrame &frame) {
  GstVideoFrame whole = frame;
  if (GST_VIDEO_FRAME_N_PLANES(&frame) == 1 &&
      GST_VIDEO_FORMAT_INFO_W_SUB(frame.info.finfo, 1) == 1)
    whole.info.width = GST_ROUND_UP_2(whole.info.width);
  return whole;
}

bool copy(const GstVideoFrame &from, GstVideoFrame &to) {
  const GstVideoFrame source = whole_pairs(from);
  GstVideoFrame target = whole_pairs(to);
  return gst_video_frame_copy(&target, &source);
}

bool blend(const GstVideoInfo &info, const Drawn &drawn, GstBuffer *in, GstBuffer *out) {
  haptic::MappedFrame frame(info, out, GST_MAP_READWRITE);
  if (!frame)
    return false;
  if (in != out) {
    const haptic::MappedFrame original(info, in);
    if (!original || !copy(original.frame(), frame.frame()))
      return false;
  }
  int x = 0;
  int y = 0;
  GstVideoFrame part = part_of(frame.frame(), drawn.extent, x, y);
  return gst_video_overlay_composition_blend(compose(drawn, x, y).get(), &part);
}

GstFlowReturn draw(GstHapticOverlay *self, GstBuffer *in, GstBuffer *out) {
  State &state = *self->state;
  const std::optional<Drawn> drawn = std::exchange(state.drawn, std::nullopt);
  if (!drawn)
    return GST_FLOW_OK;
  if (state.attaches) {
    gst_buffer_add_video_overlay_composition_meta(
        out, compose(*drawn, drawn->extent.x, drawn->extent.y).get());
    return GST_FLOW_OK;
  }
  if (!blend(GST_VIDEO_FILTER(self)->out_info, *drawn, in, out)) {
    GST_ELEMENT_ERROR(self, STREAM, FORMAT,
                      ("A frame cannot be drawn on: its memory does not hold what its format "
                       "says."),
                      ("%" GST_PTR_FORMAT, static_cast<void *>(in)));
    return GST_FLOW_ERROR;
  }
  return GST_FLOW_OK;
}

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

} // namespace

// Better that downstream draws than that a copy is made.
static GstCaps *gst_haptic_overlay_transform_caps(GstBaseTransform *trans,
                                                  GstPadDirection direction, GstCaps *caps,
                                                  GstCaps *filter) {
  return guarded(trans, static_cast<GstCaps *>(nullptr), [&] {
    haptic::CapsPtr result = without_composition(caps);
    if (direction == GST_PAD_SINK) {
      haptic::CapsPtr preferred = with_composition(result.get());
      result.reset(gst_caps_merge(preferred.release(), result.release()));
    }
    if (filter)
      result.reset(gst_caps_intersect_full(filter, result.get(), GST_CAPS_INTERSECT_FIRST));
    return result.release();
  });
}

static gboolean gst_haptic_overlay_set_caps(GstBaseTransform *trans, GstCaps *in, GstCaps *out) {
  const gboolean result =
      GST_BASE_TRANSFORM_CLASS(gst_haptic_overlay_parent_class)->set_caps(trans, in, out);
  // Which the parent takes it to be, but copies then come from no pool.
  gst_base_transform_set_in_place(trans, FALSE);
  return result;
}

static gboolean gst_haptic_overlay_decide_allocation(GstBaseTransform *trans, GstQuery *query) {
  return guarded(trans, FALSE, [&] {
    GstCaps *caps = nullptr;
    gst_query_parse_allocation(query, &caps, nullptr);
    GST_HAPTIC_OVERLAY(trans)->state->attaches =
        caps &&
        gst_caps_features_contains(gst_caps_get_features(caps, 0),
                                   GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION) &&
        gst_query_find_allocation_meta(query, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
    return GST_BASE_TRANSFORM_CLASS(gst_haptic_overlay_parent_class)
        ->decide_allocation(trans, query);
  });
}

static GstFlowReturn gst_haptic_overlay_prepare_output_buffer(GstBaseTransform *trans,
                                                              GstBuffer *in, GstBuffer **out) {
  return guarded(trans, GST_FLOW_ERROR,
                 [&] { return prepare(GST_HAPTIC_OVERLAY(trans), in, out); });
}

static GstFlowReturn gst_haptic_overlay_transform(GstBaseTransform *trans, GstBuffer *in,
                                                  GstBuffer *out) {
  return guarded(trans, GST_FLOW_ERROR, [&] { return draw(GST_HAPTIC_OVERLAY(trans), in, out); });
}

// The geometry stays as it is, so all metadata stay true.
static gboolean gst_haptic_overlay_transform_meta(GstBaseTransform *, GstBuffer *, GstMeta *,
                                                  GstBuffer *) {
  return TRUE;
}

static gboolean gst_haptic_overlay_start(GstBaseTransform *trans) {
  GST_HAPTIC_OVERLAY(trans)->state->reader = {};
  return TRUE;
}

static void gst_haptic_overlay_set_property(GObject *object, guint id, const GValue *value,
                                            GParamSpec *pspec) {
  OverlayLook &look = GST_HAPTIC_OVERLAY(object)->state->look;
  const ObjectLock lock(object);
  switch (id) {
  case kStyle:
    look.style = static_cast<OverlayStyle>(g_value_get_enum(value));
    break;
  case kVelocityColor:
    look.velocity_color = g_value_get_uint(value);
    break;
  case kForceColor:
    look.force_color = g_value_get_uint(value);
    break;
  case kScale:
    look.scale = g_value_get_double(value);
    break;
  default:
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
  }
}

static void gst_haptic_overlay_get_property(GObject *object, guint id, GValue *value,
                                            GParamSpec *pspec) {
  const OverlayLook &look = GST_HAPTIC_OVERLAY(object)->state->look;
  const ObjectLock lock(object);
  switch (id) {
  case kStyle:
    g_value_set_enum(value, static_cast<gint>(look.style));
    break;
  case kVelocityColor:
    g_value_set_uint(value, look.velocity_color);
    break;
  case kForceColor:
    g_value_set_uint(value, look.force_color);
    break;
  case kScale:
    g_value_set_double(value, look.scale);
    break;
  default:
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
  }
}

static void gst_haptic_overlay_finalize(GObject *object) {
  delete GST_HAPTIC_OVERLAY(object)->state;
  G_OBJECT_CLASS(gst_haptic_overlay_parent_class)->finalize(object);
}

static void gst_haptic_overlay_init(GstHapticOverlay *self) {
  self->state = new State;
  auto *trans = GST_BASE_TRANSFORM(self);
  // A frame skipped here would be missing from the history that a duplicate repeats.
  gst_base_transform_set_qos_enabled(trans, FALSE);
  gst_base_transform_set_gap_aware(trans, TRUE);
}

static void gst_haptic_overlay_class_init(GstHapticOverlayClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);
  const OverlayLook look;
  const auto flags = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS |
                                              GST_PARAM_MUTABLE_PLAYING);

  object_class->set_property = gst_haptic_overlay_set_property;
  object_class->get_property = gst_haptic_overlay_get_property;
  object_class->finalize = gst_haptic_overlay_finalize;
  g_object_class_install_property(object_class, kStyle,
                                  g_param_spec_enum("style", "Style", "What is drawn", style_type(),
                                                    static_cast<gint>(look.style), flags));
  g_object_class_install_property(object_class, kVelocityColor,
                                  g_param_spec_uint("velocity-color", "Velocity Color",
                                                    "Of velocity and patches, ARGB", 0, G_MAXUINT32,
                                                    look.velocity_color, flags));
  g_object_class_install_property(object_class, kForceColor,
                                  g_param_spec_uint("force-color", "Force Color",
                                                    "Of the force, ARGB", 0, G_MAXUINT32,
                                                    look.force_color, flags));
  g_object_class_install_property(
      object_class, kScale,
      g_param_spec_double("scale", "Scale",
                          "Seconds of motion that an arrow is long; none is longer than half of "
                          "the frame's height",
                          0, kLongestScale, look.scale, flags));

  gst_element_class_set_static_metadata(
      element_class, "Haptic overlay", "Filter/Effect/Video",
      "Draws over a frame the motion that was measured in it and the force that it gives",
      "Feeling Wind project");
  gst_element_class_add_static_pad_template(element_class, &sink_template);
  gst_element_class_add_static_pad_template(element_class, &src_template);

  transform_class->transform_caps = gst_haptic_overlay_transform_caps;
  transform_class->set_caps = gst_haptic_overlay_set_caps;
  transform_class->decide_allocation = gst_haptic_overlay_decide_allocation;
  transform_class->prepare_output_buffer = gst_haptic_overlay_prepare_output_buffer;
  // Not GstVideoFilter's own, which maps, and so copies, what is not drawn on.
  transform_class->transform = gst_haptic_overlay_transform;
  transform_class->transform_meta = gst_haptic_overlay_transform_meta;
  transform_class->start = gst_haptic_overlay_start;

  gst_type_mark_as_plugin_api(style_type(), static_cast<GstPluginAPIFlags>(0));
}
