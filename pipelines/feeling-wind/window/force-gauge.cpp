// SPDX-License-Identifier: LGPL-2.1-or-later
#include "window/force-gauge.hpp"

#include "gsthapticmotionmeta.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gst/video/video.h>

namespace program {
namespace {

constexpr double kBarWidth = 8;
constexpr double kBarHeight = 56;
constexpr double kMargin = 8;
constexpr double kTextSize = 12;
constexpr double kTextRoom = 48;

// The sides of the region in the widget.
struct Place {
  double right, left, bottom;
};

Place place_of(const GstHapticMotionMeta &motion, const GstVideoInfo &info, double width,
               double height) {
  const double par = static_cast<double>(info.par_n) / info.par_d;
  const double frame_width = motion.frame_width * par;
  const double scale = std::min(width / frame_width, height / motion.frame_height);
  const double left = (width - scale * frame_width) / 2;
  const double top = (height - scale * motion.frame_height) / 2;
  const auto region_x = static_cast<double>(motion.region_x);
  const auto region_width = static_cast<double>(motion.region_width);
  return {left + scale * par * (region_x + region_width), left + scale * par * region_x,
          top + scale * static_cast<double>(motion.region_y + motion.region_height)};
}

} // namespace

void draw_force_gauge(cairo_t *cairo, GstSample *frame, double width, double height,
                      double max_force) {
  GstVideoInfo info;
  const auto *motion = gst_buffer_get_haptic_motion_meta(gst_sample_get_buffer(frame));
  GstCaps *caps = gst_sample_get_caps(frame);
  if (!motion || !caps || !gst_video_info_from_caps(&info, caps) || motion->frame_width == 0 ||
      max_force <= 0)
    return;
  const double force =
      std::hypot(static_cast<double>(motion->force_x), static_cast<double>(motion->force_y));
  if (!std::isfinite(force))
    return;
  const Place place = place_of(*motion, info, width, height);
  double x = place.right + kMargin;
  if (x + kBarWidth + kTextRoom > width)
    x = place.left - kMargin - kBarWidth - kTextRoom;
  // No lower than the region: below it is the name of the model.
  const double y =
      std::clamp(place.bottom - kBarHeight - 2, 2.0, std::max(2.0, height - kBarHeight - 2));
  const double full = kBarHeight * std::min(1.0, force / max_force);

  cairo_new_path(cairo); // the film left one
  cairo_set_source_rgba(cairo, 0, 0, 0, 0.6);
  cairo_rectangle(cairo, x - 2, y - 2, kBarWidth + kTextRoom, kBarHeight + 4);
  cairo_fill(cairo);
  cairo_set_source_rgb(cairo, 0.34, 0.71, 0.91); // the blue of the force
  cairo_rectangle(cairo, x, y + kBarHeight - full, kBarWidth, full);
  cairo_fill(cairo);
  cairo_set_source_rgb(cairo, 1, 1, 1);
  cairo_set_line_width(cairo, 1);
  cairo_rectangle(cairo, x + 0.5, y + 0.5, kBarWidth - 1, kBarHeight - 1);
  cairo_stroke(cairo);
  char text[16];
  std::snprintf(text, sizeof text, "%.2f N", force);
  cairo_select_font_face(cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, kTextSize);
  cairo_move_to(cairo, x + kBarWidth + 4, y + kBarHeight / 2 + kTextSize / 3);
  cairo_show_text(cairo, text);
}

} // namespace program
