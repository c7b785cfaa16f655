// SPDX-License-Identifier: LGPL-2.1-or-later
#include "window/strip-chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace program {
namespace {

constexpr double kSpan = 8; // s
// Smallest full scale of the axes, so that noise does not fill the strip.
constexpr double kLeastVelocity = 20; // px/s
constexpr double kLeastForce = 0.1;   // N
constexpr double kText = 12;          // px, font size

struct Color {
  double r, g, b;
};
// The colours of hapticoverlay. Orange on white is too faint for text, so it is darker there.
struct LaneColor {
  Color on_dark, on_light;
};
constexpr LaneColor kVelocity{{0.90, 0.62, 0}, {0.70, 0.37, 0}};
constexpr LaneColor kForce{{0.34, 0.71, 0.91}, {0, 0.45, 0.70}};

struct Lane {
  const char *name;
  const char *unit;
  LaneColor color;
  double least;                                // smallest full scale
  std::array<double Reading::*, 2> components; // x solid, y dashed
  double down;                                 // 1: positive y is drawn downwards
};
constexpr std::array kLanes = {
    Lane{"velocity", "px/s", kVelocity, kLeastVelocity, {&Reading::vx, &Reading::vy}, 1},
    Lane{"force", "N", kForce, kLeastForce, {&Reading::fx, &Reading::fy}, -1}};

bool is_dark(const GdkRGBA &color) {
  return 0.299 * color.red + 0.587 * color.green + 0.114 * color.blue < 0.5;
}

void show_text(cairo_t *cairo, double x, double y, const std::string &text) {
  cairo_move_to(cairo, x, y);
  cairo_show_text(cairo, text.c_str());
}

} // namespace

void StripChart::add(const Reading &reading) {
  readings_.push_back(reading);
  double length = 0;
  for (const Reading &r : readings_)
    length += r.duration;
  while (length - readings_.front().duration > kSpan) {
    length -= readings_.front().duration;
    readings_.pop_front();
  }
}

namespace {

double full_scale(const Lane &lane, const std::deque<Reading> &readings) {
  double largest = lane.least;
  for (const Reading &r : readings)
    for (const auto component : lane.components)
      if (std::isfinite(r.*component))
        largest = std::max(largest, std::abs(r.*component));
  return largest;
}

// `top` and `height` are those of the lane.
void draw_lane(cairo_t *cairo, const Lane &lane, const std::deque<Reading> &readings, double width,
               double top, double height, const ChartColors &colors) {
  const double middle = top + height / 2;
  const double largest = full_scale(lane, readings);
  cairo_set_line_width(cairo, 2);
  constexpr double kDash[] = {5, 4};
  for (std::size_t c = 0; c < lane.components.size(); ++c) {
    cairo_set_dash(cairo, kDash, c == 0 ? 0 : 2, 0);
    const double towards = c == 0 ? -1 : lane.down; // positive x is drawn upwards
    double x = width;
    for (std::size_t i = readings.size(); i-- > 0;) {
      const Reading &r = readings[i];
      const double value = r.*lane.components[c];
      if (std::isfinite(value))
        cairo_line_to(cairo, x, middle + towards * value / largest * height * 0.45);
      else
        cairo_new_sub_path(cairo);
      x -= r.duration / kSpan * width;
    }
    cairo_stroke(cairo);
  }
  cairo_set_dash(cairo, nullptr, 0, 0);
  char text[80];
  std::snprintf(text, sizeof text, "%s, ±%.3g %s: x solid, y dashed", lane.name, largest,
                lane.unit);
  // On a ground of its own, where curves pass below it.
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, text, &extents);
  cairo_pattern_t *ink = cairo_pattern_reference(cairo_get_source(cairo));
  const GdkRGBA &ground = colors.background;
  cairo_set_source_rgba(cairo, ground.red, ground.green, ground.blue, 0.8);
  cairo_rectangle(cairo, 2, top + 1, extents.x_advance + 8, 1.5 * kText);
  cairo_fill(cairo);
  cairo_set_source(cairo, ink);
  cairo_pattern_destroy(ink);
  show_text(cairo, 6, top + 1.2 * kText, text);
}

} // namespace

void StripChart::draw(cairo_t *cairo, double width, double height,
                      const ChartColors &colors) const {
  const bool dark = is_dark(colors.background);
  cairo_rectangle(cairo, 0, 0, width, height);
  cairo_clip_preserve(cairo); // the surface covers the whole window
  gdk_cairo_set_source_rgba(cairo, &colors.background);
  cairo_fill(cairo);
  cairo_select_font_face(cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, kText);
  const double lane_height = height / static_cast<double>(kLanes.size());
  for (std::size_t i = 0; i < kLanes.size(); ++i) {
    const double top = lane_height * static_cast<double>(i);
    const double middle = std::floor(top + lane_height / 2) + 0.5;
    cairo_set_source_rgba(cairo, colors.text.red, colors.text.green, colors.text.blue, 0.3);
    cairo_set_line_width(cairo, 1);
    cairo_move_to(cairo, 0, middle);
    cairo_line_to(cairo, width, middle);
    cairo_stroke(cairo);
    const Color &color = dark ? kLanes[i].color.on_dark : kLanes[i].color.on_light;
    cairo_set_source_rgb(cairo, color.r, color.g, color.b);
    draw_lane(cairo, kLanes[i], readings_, width, top, lane_height, colors);
  }
}

} // namespace program
