// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/marked-object.hpp"

#include <algorithm>
#include <gst/video/gstvideometa.h>

#ifdef HAVE_GST_ANALYTICS
#include <gst/analytics/analytics.h>
#endif

namespace haptic {
namespace {

class SmallestObject {
public:
  SmallestObject(int x, int y, int frame_width, int frame_height)
      : x_(x), y_(y), frame_width_(frame_width), frame_height_(frame_height) {}

  // 64 bits: a box of somebody else's may end anywhere.
  void add(GQuark kind, gint64 x, gint64 y, gint64 width, gint64 height) {
    if (const char *name = g_quark_to_string(kind); name && g_str_has_prefix(name, "haptic-"))
      return;
    const gint64 left = std::max<gint64>(x, 0);
    const gint64 top = std::max<gint64>(y, 0);
    const gint64 right = std::min<gint64>(x + width, frame_width_);
    const gint64 bottom = std::min<gint64>(y + height, frame_height_);
    if (x_ < left || x_ >= right || y_ < top || y_ >= bottom)
      return;
    const gint64 area = (right - left) * (bottom - top);
    if (box_ && area >= static_cast<gint64>(box_->width) * box_->height)
      return;
    box_ = {static_cast<int>(left), static_cast<int>(top), static_cast<int>(right - left),
            static_cast<int>(bottom - top)};
  }

  const std::optional<Rectangle> &box() const { return box_; }

private:
  int x_;
  int y_;
  int frame_width_;
  int frame_height_;
  std::optional<Rectangle> box_;
};

} // namespace

std::optional<Rectangle> marked_object_at(GstBuffer *buffer, int x, int y, int frame_width,
                                          int frame_height) {
  SmallestObject smallest(x, y, frame_width, frame_height);
  gpointer cursor = nullptr;
  while (GstMeta *meta = gst_buffer_iterate_meta_filtered(
             buffer, &cursor, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE)) {
    const auto *region = reinterpret_cast<GstVideoRegionOfInterestMeta *>(meta);
    smallest.add(region->roi_type, region->x, region->y, region->w, region->h);
  }
#ifdef HAVE_GST_ANALYTICS
  if (GstAnalyticsRelationMeta *relations = gst_buffer_get_analytics_relation_meta(buffer)) {
    GstAnalyticsODMtd object;
    for (gpointer state = nullptr; gst_analytics_relation_meta_iterate(
             relations, &state, gst_analytics_od_mtd_get_mtd_type(), &object);) {
      gint left = 0;
      gint top = 0;
      gint width = 0;
      gint height = 0;
      gfloat confidence = 0;
      if (gst_analytics_od_mtd_get_location(&object, &left, &top, &width, &height, &confidence))
        smallest.add(gst_analytics_od_mtd_get_obj_type(&object), left, top, width, height);
    }
  }
#endif
  return smallest.box();
}

} // namespace haptic
