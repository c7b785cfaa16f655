// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gsthapticmotionmeta.h"

#include <algorithm>
#include <cmath>
#include <gst/video/gstvideometa.h>
#include <gst/video/video.h>
#include <limits>
#include <span>

namespace {

// Elements that do not keep the frame's geometry (crop, composite) drop metadata tagged so,
// rather than carry wrong coordinates.
GType api_type() {
  static const GType type = [] {
    static const gchar *tags[] = {GST_META_TAG_VIDEO_STR, GST_META_TAG_VIDEO_SIZE_STR,
                                  GST_META_TAG_VIDEO_ORIENTATION_STR, nullptr};
    return gst_meta_api_type_register("GstHapticMotionMetaAPI", tags);
  }();
  return type;
}

GstHapticMotionMeta *cast(GstMeta *meta) {
  return reinterpret_cast<GstHapticMotionMeta *>(meta);
}

void copy_fields(const GstHapticMotionMeta &from, GstHapticMotionMeta &to) {
  const GstMeta header = to.meta;
  to = from;
  to.meta = header;
}

void scale_patch(GstHapticPatch &patch, gfloat sx, gfloat sy) {
  patch.x *= sx;
  patch.y *= sy;
  patch.width *= sx;
  patch.height *= sy;
  patch.dx *= sx;
  patch.dy *= sy;
  patch.precision_xx /= sx * sx;
  patch.precision_xy /= sx * sy;
  patch.precision_yy /= sy * sy;
}

void scale_fields(GstHapticMotionMeta &meta, guint width, guint height) {
  const auto sx = static_cast<gfloat>(width) / static_cast<gfloat>(meta.frame_width);
  const auto sy = static_cast<gfloat>(height) / static_cast<gfloat>(meta.frame_height);
  meta.frame_width = width;
  meta.frame_height = height;
  for (gfloat *x : {&meta.region_x, &meta.region_width, &meta.pointer_x, &meta.proxy_x,
                    &meta.held_x, &meta.held_radius})
    *x *= sx;
  for (gfloat *y :
       {&meta.region_y, &meta.region_height, &meta.pointer_y, &meta.proxy_y, &meta.held_y})
    *y *= sy;
  // Other programs write the metadata, too.
  for (GstHapticPatch &patch :
       std::span(meta.patches)
           .first(std::min<std::size_t>(meta.n_patches, std::size(meta.patches))))
    scale_patch(patch, sx, sy);
}

gboolean init(GstMeta *meta, gpointer, GstBuffer *) {
  constexpr auto kUnknown = std::numeric_limits<gfloat>::quiet_NaN();
  copy_fields({.force_x = kUnknown,
               .force_y = kUnknown,
               .force_z = kUnknown,
               .proxy_x = kUnknown,
               .proxy_y = kUnknown,
               .depth = kUnknown},
              *cast(meta));
  return TRUE;
}

double display_aspect(const GstVideoInfo &info) {
  return static_cast<double>(GST_VIDEO_INFO_WIDTH(&info)) * GST_VIDEO_INFO_PAR_N(&info) /
         (static_cast<double>(GST_VIDEO_INFO_HEIGHT(&info)) * GST_VIDEO_INFO_PAR_D(&info));
}

// Into a frame of another shape videoscale draws borders, unless told otherwise. Nothing says how
// wide they are, and no motion is better than a wrong one. (What rounding makes of a shape is
// less.)
bool keeps_shape(const GstVideoMetaTransform &scaled) {
  constexpr double kRounding = 0.02;
  const double ratio = display_aspect(*scaled.out_info) / display_aspect(*scaled.in_info);
  return std::abs(ratio - 1) <= kRounding;
}

gboolean transform(GstBuffer *to, GstMeta *meta, GstBuffer *, GQuark type, gpointer data) {
  const bool is_copy = GST_META_TRANSFORM_IS_COPY(type);
  if (!is_copy && !GST_VIDEO_META_TRANSFORM_IS_SCALE(type))
    return FALSE;
  if (!is_copy && !keeps_shape(*static_cast<const GstVideoMetaTransform *>(data)))
    return FALSE;
  GstHapticMotionMeta *copy = gst_buffer_add_haptic_motion_meta(to);
  copy_fields(*cast(meta), *copy);
  if (!is_copy && copy->frame_width > 0 && copy->frame_height > 0) {
    const GstVideoInfo *out = static_cast<const GstVideoMetaTransform *>(data)->out_info;
    scale_fields(*copy, static_cast<guint>(GST_VIDEO_INFO_WIDTH(out)),
                 static_cast<guint>(GST_VIDEO_INFO_HEIGHT(out)));
  }
  return TRUE;
}

const GstMetaInfo *meta_info() {
  static const GstMetaInfo *const info =
      gst_meta_register(api_type(), GST_HAPTIC_MOTION_META_NAME, sizeof(GstHapticMotionMeta), init,
                        nullptr, transform);
  return info;
}

} // namespace

GstHapticMotionMeta *gst_buffer_add_haptic_motion_meta(GstBuffer *buffer) {
  return cast(gst_buffer_add_meta(buffer, meta_info(), nullptr));
}
