// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scene/flag.hpp"

#include <algorithm>
#include <cmath>

namespace film {

namespace {

constexpr Point kPoleTop{744, 128}; // of the pole
constexpr float kPoleFoot = 452;
constexpr float kPoleWidth = 6;
constexpr float kLength = 158; // of the cloth
constexpr float kHeight = 96;
constexpr int kColumns = 36; // of triangles
constexpr int kLines = 8;

void set_wave(cairo_t *cairo, double w, double y, double amplitude, double thickness) {
  cairo_move_to(cairo, 0.12 * w, y);
  cairo_curve_to(cairo, 0.32 * w, y - amplitude, 0.45 * w, y - amplitude, 0.55 * w, y);
  cairo_curve_to(cairo, 0.65 * w, y + amplitude, 0.78 * w, y + amplitude, 0.9 * w,
                 y - 0.3 * amplitude);
  cairo_set_line_width(cairo, thickness);
  cairo_stroke(cairo);
}

// Three lines of wind on blue, woven; one px around it is transparent.
Texture make_cloth(float scale) {
  const auto width = static_cast<int>(kLength * scale) + 4;
  const auto height = static_cast<int>(kHeight * scale) + 4;
  Drawing drawing(width, height);
  cairo_t *cairo = drawing.get();
  cairo_rectangle(cairo, 1, 1, width - 3, height - 3);
  cairo_clip(cairo);
  drawing.set({0.09F, 0.24F, 0.47F});
  cairo_paint(cairo);
  cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
  drawing.set({0.93F, 0.92F, 0.88F});
  set_wave(cairo, width, 0.30 * height, 0.15 * height, 0.085 * height);
  drawing.set({0.90F, 0.55F, 0.12F});
  set_wave(cairo, width, 0.52 * height, 0.15 * height, 0.085 * height);
  drawing.set({0.93F, 0.92F, 0.88F});
  set_wave(cairo, width, 0.74 * height, 0.15 * height, 0.085 * height);
  drawing.set({0.93F, 0.92F, 0.88F}); // the hem
  cairo_rectangle(cairo, 1, 1, 0.035 * width, height);
  cairo_fill(cairo);
  Texture cloth = drawing.texture();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float weave = noise(static_cast<float>(x) * 0.55F, static_cast<float>(y) * 0.9F, 4) +
                          noise(static_cast<float>(x) * 0.05F, static_cast<float>(y) * 0.08F, 5);
      Pixel &pixel = cloth.pixels[static_cast<std::size_t>(y) * width + x];
      pixel = brighten(pixel, static_cast<unsigned>(205 + 25 * weave));
    }
  return cloth;
}

Texture make_pole(float scale) {
  const int width = std::max(4, static_cast<int>(kPoleWidth * scale) + 2);
  const auto height = static_cast<int>((kPoleFoot - kPoleTop.y) * scale);
  Texture pole{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float across = (static_cast<float>(x) - 0.5F) / static_cast<float>(width - 2);
      const float lit = 0.45F + 0.5F * std::max(0.0F, 1 - 2.4F * std::abs(across - 0.32F)) +
                        0.05F * noise(across * 9, static_cast<float>(y) * 0.05F, 8);
      const bool inside = x > 0 && x < width - 1;
      pole.pixels.push_back(inside ? unpack(opaque(Colour{0.92F, 0.91F, 0.88F} * lit)) : 0);
    }
  return pole;
}

} // namespace

Flag::Flag(const Affine &to_frame)
    : to_frame_(to_frame), cloth_(make_cloth(to_frame.xx)), pole_(make_pole(to_frame.xx)) {}

// Waves grow from the pole to the free end, run along the cloth with the wind, and their crests
// lean. A slack flag hangs. Seen a little from the right and from below.
Flag::Spot Flag::spot(const Wind &wind, float along, float down) const {
  const float strength = wind(kPoleTop.x + along * 60);
  const float crest = 10.5F * along + 1.1F * down - wind.phase(1.15F);
  const float small = 21 * along - 2.1F * down - wind.phase(2.3F);
  const float grow = along * (1.6F - 0.6F * along);
  const float towards = grow * ((6 + 11 * strength) * std::sin(crest) + 2.4F * std::sin(small));
  const float slack = std::clamp(0.95F - strength, 0.0F, 1.0F);
  const float shorter = 1 - 0.06F - 0.22F * slack;
  const float x = along * kLength * shorter + 0.42F * towards;
  const float y = down * kHeight + kLength * along * along * (0.04F + 0.42F * slack) +
                  0.30F * towards +
                  9.0F * strength * along * std::sin(wind.phase(0.7F) + 3 * along);
  return {{kPoleTop.x + kPoleWidth / 2 + x, kPoleTop.y + 7 + y}, towards};
}

void Flag::draw(Canvas &canvas, const Winds &winds) const {
  constexpr int kAcross = kColumns + 1;
  std::vector<Spot> now;
  std::vector<Spot> before;
  for (int j = 0; j <= kLines; ++j)
    for (int i = 0; i < kAcross; ++i) {
      const float along = static_cast<float>(i) / kColumns;
      const float down = static_cast<float>(j) / kLines;
      now.push_back(spot(winds.now, along, down));
      before.push_back(spot(winds.before, along, down));
    }
  const float u = (static_cast<float>(cloth_.width) - 1.1F) / kColumns;
  const float v = (static_cast<float>(cloth_.height) - 1.1F) / kLines;
  const auto triangle = [&](int j, int i, int right, int below) {
    const auto index = [](int line, int column) {
      return static_cast<std::size_t>(line) * kAcross + static_cast<std::size_t>(column);
    };
    const std::size_t corner = index(j, i);
    const std::size_t beside = index(j, i + right);
    const std::size_t under = index(j + below, i);
    const Point texel{static_cast<float>(i) * u, static_cast<float>(j) * v};
    const auto map = [&](const std::vector<Spot> &spots) {
      const Point across = (spots[beside].at - spots[corner].at) * (static_cast<float>(right) / u);
      const Point along = (spots[under].at - spots[corner].at) * (static_cast<float>(below) / v);
      const Affine shape{across.x, along.x, across.y, along.y, 0, 0};
      const Point origin = spots[corner].at - shape(texel);
      return to_frame_ * Affine{across.x, along.x, across.y, along.y, origin.x, origin.y};
    };
    // The steeper the cloth turns to the sun, the lighter it is.
    const float slope = (now[beside].towards - now[corner].towards) * static_cast<float>(right) *
                        static_cast<float>(kColumns) / kLength;
    const float light = (0.70F + 0.75F * slope) / std::sqrt(1 + slope * slope) + 0.25F;
    canvas.draw_triangle(cloth_, {map(now), map(before)}, texel,
                         texel + Point{static_cast<float>(right) * u, 0},
                         texel + Point{0, static_cast<float>(below) * v},
                         static_cast<int>(256 * std::clamp(light, 0.35F, 1.06F)),
                         {Kind::flag, 0, static_cast<std::uint32_t>(2 * corner) + (right > 0)});
  };
  for (int j = 0; j < kLines; ++j)
    for (int i = 0; i < kColumns; ++i) {
      triangle(j, i, 1, 1);
      triangle(j + 1, i + 1, -1, -1);
    }
  const Affine pole{1 / to_frame_.xx, 0, 0, 1 / to_frame_.xx, kPoleTop.x - kPoleWidth / 2,
                    kPoleTop.y};
  const Pose still{to_frame_ * pole, to_frame_ * pole};
  canvas.draw(pole_, still);
}

} // namespace film
