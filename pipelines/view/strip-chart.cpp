// SPDX-License-Identifier: LGPL-2.1-or-later
#include "strip-chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace view {
namespace {

constexpr double kSpan = 8; // s
// Smallest full scale of the axes, so that noise does not fill the strip.
constexpr double kLeastVelocity = 20; // px/s
constexpr double kLeastForce = 0.1;   // N
constexpr double kText = 12;          // px, font size

struct Color {
  double r, g, b;
};
// The colours of hapticoverlay; the blue is lighter, for the dark background.
constexpr Color kVelocity{0.90, 0.62, 0};
constexpr Color kForce{0.34, 0.71, 0.91};

struct Lane {
  const char *name;
  const char *unit;
  Color color;
  double least;                                // smallest full scale
  std::array<double Reading::*, 2> components; // x solid, y dashed
  double down;                                 // 1: positive y is drawn downwards
};
constexpr std::array kLanes = {
    Lane{"velocity", "px/s", kVelocity, kLeastVelocity, {&Reading::vx, &Reading::vy}, 1},
    Lane{"force", "N", kForce, kLeastForce, {&Reading::fx, &Reading::fy}, -1}};

void set_color(cairo_t *cairo, const Color &color, double opacity = 1) {
  cairo_set_source_rgba(cairo, color.r, color.g, color.b, opacity);
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

void StripChart::draw(cairo_t *cairo, double width, double height,
                      const std::string &caption) const {
  cairo_rectangle(cairo, 0, 0, width, height);
  cairo_clip_preserve(cairo); // the surface covers the whole window
  cairo_set_source_rgb(cairo, 0.1, 0.1, 0.1);
  cairo_fill(cairo);
  cairo_select_font_face(cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, kText);
  const double caption_height = 1.6 * kText;
  cairo_set_source_rgb(cairo, 1, 1, 1);
  show_text(cairo, 6, height - 0.5 * kText, caption);

  const double lane_height = (height - caption_height) / kLanes.size();
  for (std::size_t i = 0; i < kLanes.size(); ++i) {
    const Lane &lane = kLanes[i];
    const double middle = lane_height * (static_cast<double>(i) + 0.5);
    double largest = lane.least;
    for (const Reading &r : readings_)
      for (const auto component : lane.components)
        if (std::isfinite(r.*component))
          largest = std::max(largest, std::abs(r.*component));

    set_color(cairo, {1, 1, 1}, 0.3);
    cairo_set_line_width(cairo, 1);
    cairo_move_to(cairo, 0, std::floor(middle) + 0.5);
    cairo_line_to(cairo, width, std::floor(middle) + 0.5);
    cairo_stroke(cairo);

    set_color(cairo, lane.color);
    cairo_set_line_width(cairo, 2);
    constexpr double kDash[] = {5, 4};
    for (std::size_t c = 0; c < lane.components.size(); ++c) {
      cairo_set_dash(cairo, kDash, c == 0 ? 0 : 2, 0);
      const double towards = c == 0 ? -1 : lane.down; // positive x is drawn upwards
      double x = width;
      for (auto r = readings_.rbegin(); r != readings_.rend(); ++r) {
        const double value = (*r).*lane.components[c];
        if (std::isfinite(value))
          cairo_line_to(cairo, x, middle + towards * value / largest * lane_height * 0.45);
        else
          cairo_new_sub_path(cairo);
        x -= r->duration / kSpan * width;
      }
      cairo_stroke(cairo);
    }
    cairo_set_dash(cairo, nullptr, 0, 0);

    char text[80];
    std::snprintf(text, sizeof text, "%s, ±%.3g %s: x solid, y dashed", lane.name, largest,
                  lane.unit);
    show_text(cairo, 6, middle - lane_height / 2 + 1.2 * kText, text);
  }
}

} // namespace view
