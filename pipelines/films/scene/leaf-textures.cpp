// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scene/tree.hpp"

#include <algorithm>
#include <cmath>

namespace film {

namespace {

// From shadow, which the sky makes bluish, to leaves that the sun shines through.
Colour in_light(float light) {
  constexpr Colour kRamp[] = {{0.035F, 0.080F, 0.050F}, {0.075F, 0.150F, 0.060F},
                              {0.150F, 0.265F, 0.070F}, {0.280F, 0.420F, 0.100F},
                              {0.450F, 0.580F, 0.160F}, {0.680F, 0.760F, 0.330F}};
  const float at = std::clamp(light, 0.0F, 0.999F) * 5;
  const auto index = static_cast<int>(at);
  return mix(kRamp[index], kRamp[index + 1], at - static_cast<float>(index));
}

Colour of_kind(const Colour &colour, int kind) {
  constexpr Colour kTints[LeafTextures::kKinds] = {{1, 1, 1},
                                                   {1.10F, 1.03F, 0.85F},
                                                   {0.88F, 0.97F, 1.05F},
                                                   {1.05F, 1.05F, 1},
                                                   {1.18F, 1, 0.75F}};
  const Colour &tint = kTints[kind];
  return {colour.red * tint.red, colour.green * tint.green, colour.blue * tint.blue};
}

// Length 1 along x about y = 0; `side` −1 and 1 are the halves, 0 is all of it.
void trace_blade(cairo_t *cairo, int side, double fatness) {
  const double w = 0.36 * fatness;
  cairo_new_path(cairo);
  cairo_move_to(cairo, 0.12, 0);
  if (side <= 0)
    cairo_curve_to(cairo, 0.22, -w * 1.25, 0.62, -w * 1.25, 0.97, 0);
  else
    cairo_line_to(cairo, 0.97, 0);
  if (side >= 0)
    cairo_curve_to(cairo, 0.62, w * 1.25, 0.22, w * 1.25, 0.12, 0);
  cairo_close_path(cairo);
}

void draw_veins(Drawing &drawing, const Colour &colour, double fatness, double pixel) {
  cairo_t *cairo = drawing.get();
  cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
  drawing.set(mix(colour, {0.85F, 0.88F, 0.5F}, 0.35F), 0.85F);
  cairo_set_line_width(cairo, 1.1 * pixel);
  cairo_move_to(cairo, 0.02, 0);
  cairo_line_to(cairo, 0.93, 0);
  cairo_stroke(cairo);
  drawing.set(mix(colour, {0.85F, 0.88F, 0.5F}, 0.25F), 0.6F);
  cairo_set_line_width(cairo, 0.6 * pixel);
  for (int i = 0; i < 5; ++i)
    for (const int side : {-1, 1}) {
      const double x = 0.2 + 0.14 * i;
      cairo_move_to(cairo, x, 0);
      cairo_line_to(cairo, x + 0.15, side * 0.23 * fatness);
    }
  cairo_stroke(cairo);
}

Texture make_leaf(int width, int kind, float light) {
  const int height = static_cast<int>(std::lround(0.66 * width));
  const double fatness = 0.86 + 0.07 * kind;
  const Colour colour = of_kind(in_light(light), kind);
  Drawing drawing(width, height);
  cairo_t *cairo = drawing.get();
  cairo_translate(cairo, 1, 0.5 * height);
  cairo_scale(cairo, width - 2, width - 2);
  // The halves are folded along the midrib: one is turned to the sun.
  for (const int side : {-1, 1}) {
    const double edge = side * 0.36 * fatness;
    cairo_pattern_t *shade = cairo_pattern_create_linear(0, 0, 0.15, edge);
    const Colour near = colour * (side < 0 ? 1.0F : 0.80F);
    const Colour far = colour * (side < 0 ? 1.22F : 0.98F);
    for (const auto &[at, c] : {std::pair{0.0, near}, std::pair{1.0, far}})
      cairo_pattern_add_color_stop_rgb(shade, at, static_cast<double>(c.red),
                                       static_cast<double>(c.green), static_cast<double>(c.blue));
    trace_blade(cairo, side, fatness);
    cairo_set_source(cairo, shade);
    cairo_fill(cairo);
    cairo_pattern_destroy(shade);
  }
  draw_veins(drawing, colour, fatness, 1.0 / width);
  trace_blade(cairo, 0, fatness);
  drawing.set(colour * 0.6F, 0.5F);
  cairo_set_line_width(cairo, 0.8 / width);
  cairo_stroke(cairo);
  return drawing.texture();
}

Texture make_mass(float length, int kind) {
  const auto side = static_cast<int>(10 * length);
  Random random(static_cast<std::uint64_t>(kind) + 99);
  Drawing drawing(side, side);
  cairo_t *cairo = drawing.get();
  const auto scale = static_cast<double>(length);
  for (int i = 0; i < 330; ++i) {
    const float r = 4.2F * std::sqrt(random.between(0, 1));
    const float angle = random.between(0, 6.2832F);
    cairo_save(cairo);
    cairo_translate(cairo, side * 0.5 + scale * static_cast<double>(r * std::cos(angle)),
                    side * 0.5 + scale * static_cast<double>(r * std::sin(angle)));
    cairo_rotate(cairo, static_cast<double>(random.between(0, 6.2832F)));
    cairo_scale(cairo, scale, scale * static_cast<double>(random.between(0.4F, 1)));
    trace_blade(cairo, 0, 1);
    const float light = 0.16F + 0.10F * random.between(-1, 1) - 0.1F * std::sin(angle);
    drawing.set(of_kind(in_light(light), i % LeafTextures::kKinds));
    cairo_fill(cairo);
    cairo_restore(cairo);
  }
  return drawing.texture();
}

} // namespace

LeafTextures::LeafTextures(float length) {
  const int width = std::max(6, static_cast<int>(std::lround(length)) + 2);
  for (int kind = 0; kind < kKinds; ++kind) {
    for (int light = 0; light < kLights; ++light)
      leaves_.push_back(make_leaf(width, kind, static_cast<float>(light) / (kLights - 1)));
    masses_.push_back(make_mass(length, kind));
  }
}

const Texture &LeafTextures::leaf(int kind, float light) const {
  const int index = std::clamp(static_cast<int>(light * kLights), 0, kLights - 1);
  return leaves_[static_cast<std::size_t>(kind) * kLights + static_cast<std::size_t>(index)];
}

} // namespace film
