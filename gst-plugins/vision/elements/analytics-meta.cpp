// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/analytics-meta.hpp"

#ifdef HAVE_GST_ANALYTICS

#include "samples/held-place.hpp"

#include <algorithm>
#include <cmath>
#include <gst/analytics/analytics.h>

namespace haptic {
namespace {

// Whole pixels. False for what is no place in a frame.
bool add_box(GstAnalyticsRelationMeta *relations, const char *kind, double x, double y,
             double width, double height, GstAnalyticsODMtd *box) {
  constexpr double kMost = 1 << 20; // px, far beyond any frame
  for (const double number : {x, y, width, height})
    if (!(std::abs(number) <= kMost)) // also for NaN
      return false;
  const auto whole = [](double number) { return static_cast<gint>(std::lround(number)); };
  return gst_analytics_relation_meta_add_od_mtd(relations, g_quark_from_static_string(kind),
                                                whole(x), whole(y), whole(width), whole(height), 1,
                                                box);
}

} // namespace

// Whether a thing is followed. Another one than in the frame before gets a time of its own.
bool AnalyticsWriter::is_taken(GstClockTime now, const GstHapticMotionMeta &motion) {
  if (motion.hold == GST_HAPTIC_HOLD_NONE || motion.hold > GST_HAPTIC_HOLD_LOST ||
      !GST_CLOCK_TIME_IS_VALID(now)) {
    taken_ = GST_CLOCK_TIME_NONE;
    return false;
  }
  if (!GST_CLOCK_TIME_IS_VALID(taken_) || motion.held_time < held_time_)
    last_seen_ = taken_ = now - std::min(now, motion.held_time);
  held_time_ = motion.held_time;
  return true;
}

void AnalyticsWriter::attach(GstBuffer *buffer, const GstHapticMotionMeta &motion) {
  GstAnalyticsRelationMeta *relations = gst_buffer_get_analytics_relation_meta(buffer);
  if (!relations)
    relations = gst_buffer_add_analytics_relation_meta(buffer);
  GstAnalyticsODMtd box;
  add_box(relations, "haptic-roi", motion.region_x, motion.region_y, motion.region_width,
          motion.region_height, &box);

  const GstClockTime now = GST_BUFFER_PTS(buffer);
  if (!is_taken(now, motion))
    return;
  const bool is_seen = is_followed(static_cast<HoldState>(motion.hold));
  if (is_seen)
    last_seen_ = now;
  // The frame in which a thing was taken tells it from others.
  GstAnalyticsTrackingMtd track;
  if (!gst_analytics_relation_meta_add_tracking_mtd(relations, taken_, taken_, &track))
    return;
  gst_analytics_tracking_mtd_update_last_seen(&track, last_seen_);
  if (motion.hold == GST_HAPTIC_HOLD_LOST)
    gst_analytics_tracking_mtd_set_lost(&track);
  // No box where the place is a guess: readers take boxes for things that are seen.
  const auto radius = static_cast<double>(motion.held_radius);
  if (is_seen && add_box(relations, "haptic-held", static_cast<double>(motion.held_x) - radius,
                         static_cast<double>(motion.held_y) - radius, 2 * radius, 2 * radius, &box))
    gst_analytics_relation_meta_set_relation(relations, GST_ANALYTICS_REL_TYPE_RELATE_TO, box.id,
                                             track.id);
}

} // namespace haptic

#else

namespace haptic {

void AnalyticsWriter::attach(GstBuffer *, const GstHapticMotionMeta &) {}

} // namespace haptic

#endif
