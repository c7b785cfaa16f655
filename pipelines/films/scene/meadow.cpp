// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scene/meadow.hpp"

#include "scene/sky.hpp"
#include "scene/tree.hpp"

#include <algorithm>
#include <cmath>

namespace film {

namespace {

constexpr int kRows = 17;
constexpr float kBottom = 572; // px of a frame 540 px high: the foot of the nearest row
constexpr int kBlades = 330;

// Share of the bend at this height above the foot, 0..1.
float bend_at(float height) {
  return height * (0.5F + 0.5F * height);
}

// Of the tree, 0..1.
float shadow_at(float x, float y) {
  return 1 - smooth_step(0.35F, 1.0F,
                         std::hypot((x - Tree::kFoot.x - 60) / 330, (y - Tree::kFoot.y - 8) / 60));
}

Colour grass_colour(Random &random, float near, float clump) {
  const Colour far_green{0.50F, 0.57F, 0.33F};
  const Colour near_green{0.25F, 0.39F, 0.10F};
  Colour colour = mix(far_green, near_green, near);
  colour = mix(colour, {0.52F, 0.53F, 0.20F}, 0.55F * clump);
  return colour * random.between(0.62F, 1.22F);
}

void draw_flower(Drawing &drawing, Random &random, double x, double top, double size) {
  constexpr Colour kPetals[] = {
      {0.76F, 0.12F, 0.08F}, {0.84F, 0.83F, 0.80F}, {0.84F, 0.70F, 0.12F}};
  const float pick = random.between(0, 1);
  const Colour colour = kPetals[pick < 0.45F ? 0 : pick < 0.8F ? 1 : 2];
  cairo_t *cairo = drawing.get();
  drawing.set(colour * 0.8F);
  cairo_arc(cairo, x, top + 0.25 * size, size, 0, 6.3);
  cairo_fill(cairo);
  drawing.set(colour);
  cairo_arc(cairo, x - 0.2 * size, top - 0.1 * size, 0.75 * size, 0, 6.3);
  cairo_fill(cairo);
}

// Blades of one row side by side, tips in the light.
Texture make_strip(int width, float height, float scale, float near, std::uint64_t seed) {
  const auto rows = static_cast<int>(height * scale * 1.45F) + 2;
  Drawing drawing(width, rows);
  cairo_t *cairo = drawing.get();
  Random random(seed);
  const double thick = static_cast<double>(scale) * (0.8 + 1.5 * static_cast<double>(near));
  // Between the blades one looks into the shade.
  cairo_pattern_t *shade = cairo_pattern_create_linear(0, 0.45 * rows, 0, rows);
  const Colour deep = mix({0.42F, 0.49F, 0.28F}, {0.10F, 0.17F, 0.045F}, std::sqrt(near));
  for (const auto &[at, alpha] : {std::pair{0.0, 0.0}, std::pair{0.5, 0.9}, std::pair{1.0, 1.0}})
    cairo_pattern_add_color_stop_rgba(shade, at, static_cast<double>(deep.red),
                                      static_cast<double>(deep.green),
                                      static_cast<double>(deep.blue), alpha);
  cairo_set_source(cairo, shade);
  cairo_paint(cairo);
  cairo_pattern_destroy(shade);
  const int count = static_cast<int>(width / thick * 1.7);
  for (int i = 0; i < count; ++i) {
    const float x = random.between(0, static_cast<float>(width));
    const float clump = noise(x / scale * 0.02F, 0.5F, seed);
    const float tall = height * scale * random.between(0.55F, 1.05F) * (0.75F + 0.45F * clump);
    const float lean = tall * 0.4F * random.normal() * 0.6F;
    const auto top = static_cast<double>(static_cast<float>(rows) - tall);
    const auto foot = static_cast<double>(x);
    const auto tip = static_cast<double>(x + lean);
    const Colour colour = grass_colour(random, near, smooth_step(0.3F, 0.8F, clump));
    cairo_pattern_t *light = cairo_pattern_create_linear(0, top, 0, rows);
    const Colour lit = mix(colour * 1.25F, {0.75F, 0.75F, 0.42F}, 0.22F);
    const Colour dark = mix(colour * 0.45F, deep, 0.5F);
    cairo_pattern_add_color_stop_rgb(light, 0, static_cast<double>(lit.red),
                                     static_cast<double>(lit.green), static_cast<double>(lit.blue));
    cairo_pattern_add_color_stop_rgb(light, 0.45, static_cast<double>(colour.red),
                                     static_cast<double>(colour.green),
                                     static_cast<double>(colour.blue));
    cairo_pattern_add_color_stop_rgb(light, 1, static_cast<double>(dark.red),
                                     static_cast<double>(dark.green),
                                     static_cast<double>(dark.blue));
    cairo_move_to(cairo, foot - thick / 2, rows);
    cairo_curve_to(cairo, foot - thick / 2, rows - 0.5 * static_cast<double>(tall), foot,
                   rows - 0.75 * static_cast<double>(tall), tip, top);
    cairo_curve_to(cairo, foot + thick / 2, rows - 0.7 * static_cast<double>(tall),
                   foot + thick / 2, rows - 0.45 * static_cast<double>(tall), foot + thick / 2,
                   rows);
    cairo_set_source(cairo, light);
    cairo_fill(cairo);
    cairo_pattern_destroy(light);
    if (random.between(0, 1) < 0.012F + 0.05F * smooth_step(0.6F, 0.9F, clump))
      draw_flower(drawing, random, tip, top + 1.5 * thick,
                  thick * (0.7 + 0.6 * static_cast<double>(near)));
  }
  return drawing.texture();
}

} // namespace

Meadow::Meadow(int width, const Affine &to_frame, std::uint64_t seed)
    : to_frame_(to_frame), margin_(static_cast<int>(130 * to_frame.xx)) {
  Random random(seed ^ 0x6d656164);
  for (int i = kRows - 1; i >= 0; --i) {
    const float near = static_cast<float>(i) / (kRows - 1);
    const float foot = mix(Sky::kHorizon + 6, kBottom, near * std::sqrt(near));
    const float height = mix(8, 54, near);
    rows_.push_back({foot, height, height * 0.85F,
                     make_strip(width + 2 * margin_, height, to_frame.xx, near,
                                seed + static_cast<std::uint64_t>(i))});
  }
  for (int i = 0; i < kBlades; ++i) {
    // Long ones at both sides, where they hide nothing.
    const float side = random.between(-1, 1);
    const float x = 480 + 560 * side;
    const Colour colour = grass_colour(random, 1, random.between(0, 0.8F)) * 0.8F;
    blades_.push_back({{x, 556},
                       random.between(34, 70) + 90 * side * side * random.between(0.3F, 1),
                       random.between(-22, 22),
                       random.between(2.2F, 4.4F),
                       unpack(opaque(colour * 0.55F)),
                       unpack(opaque(mix(colour * 1.2F, {0.8F, 0.78F, 0.4F}, 0.3F))),
                       {34, 9, random.between(0.8F, 1.7F), random.between(0, 6.28F), x}});
  }
}

void Meadow::draw(Canvas &canvas, const Winds &winds, bool far) const {
  if (!far)
    for (const Blade &blade : blades_)
      draw_blade(canvas, blade, winds);
  for (const Row &row : rows_)
    if ((row.foot < Tree::kFoot.y + 4) == far)
      draw_strip(canvas, row, winds);
}

void Meadow::draw_strip(Canvas &canvas, const Row &row, const Winds &winds) const {
  const auto width = static_cast<std::size_t>(canvas.width());
  const float scale = to_frame_.xx;
  std::vector<float> now(width);
  std::vector<float> before(width);
  std::vector<std::uint16_t> gain(width);
  const float ripple = 1.05F + 0.08F * std::sin(row.foot);
  const auto bend_of = [&](const Wind &wind, float x) {
    return row.bend * scale * Sway{1, ripple, 1.1F, -x * 0.017F + 0.02F * row.foot, x}(wind);
  };
  constexpr std::size_t kStep = 8; // px; between them linear
  float left_now = 0;
  float left_before = 0;
  for (std::size_t x = 0; x < width + kStep; x += kStep) {
    const float at = (static_cast<float>(x) - to_frame_.x0) / scale;
    const float right_now = bend_of(winds.now, at);
    const float right_before = bend_of(winds.before, at);
    const float shade = 1 - 0.45F * shadow_at(at, row.foot);
    for (std::size_t i = x >= kStep ? x - kStep : 0; i < std::min(x, width); ++i) {
      const float part = static_cast<float>(i + kStep - x) / kStep;
      now[i] = mix(left_now, right_now, part);
      before[i] = mix(left_before, right_before, part);
      // Bent blades show their light side. No colour of the grass is above 0.84.
      gain[i] = static_cast<std::uint16_t>(
          256 * std::clamp(shade * (0.98F + 0.20F * now[i] / (row.bend * scale)), 0.3F, 1.18F));
    }
    left_now = right_now;
    left_before = right_before;
  }
  const int bottom = static_cast<int>(to_frame_({0, row.foot}).y);
  for (int y = 0; y < row.grass.height; ++y) {
    const float height =
        static_cast<float>(row.grass.height - y) / static_cast<float>(row.grass.height);
    canvas.draw_row(row.grass.row(y), row.grass.width, bottom - row.grass.height + y,
                    {now, before, bend_at(height), static_cast<float>(margin_)}, gain,
                    {Kind::grass, static_cast<std::uint32_t>(&row - rows_.data()),
                     static_cast<std::uint32_t>(y)});
  }
}

void Meadow::draw_blade(Canvas &canvas, const Blade &blade, const Winds &winds) const {
  const float now = blade.lean + blade.sway(winds.now);
  const float moved = now - blade.lean - blade.sway(winds.before);
  const float scale = to_frame_.xx;
  const Point foot = to_frame_(blade.foot);
  const float tall = blade.height * scale;
  for (int y = static_cast<int>(std::ceil(foot.y - tall)); y <= static_cast<int>(foot.y); ++y) {
    const float share = (foot.y - static_cast<float>(y)) / tall;
    const float bend = share * share * scale;
    const float width = blade.width * scale * (1 - 0.9F * share * share);
    const auto weight = static_cast<Pixel>(std::clamp(share, 0.0F, 1.0F) * 256);
    const Pixel colour = ((blade.colour * (256 - weight) + blade.tip * weight) >> 8) & kLanes;
    canvas.draw_span(y, foot.x + bend * now - width / 2, width, colour, to_motion(bend * moved, 0),
                     {Kind::blade, static_cast<std::uint32_t>(&blade - blades_.data()),
                      static_cast<std::uint32_t>(y)});
  }
}

} // namespace film
