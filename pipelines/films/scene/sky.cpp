// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scene/sky.hpp"

#include <algorithm>
#include <cmath>

namespace film {

namespace {

constexpr float kDrift = 9;      // px/s of a frame 540 px high, to the right
constexpr float kLongest = 60;   // s that the clouds are enough for
constexpr float kHillsTop = 318; // px of a frame 540 px high

Colour clear_sky(float height) {
  constexpr Colour kTop{0.27F, 0.47F, 0.73F};
  constexpr Colour kMiddle{0.52F, 0.69F, 0.86F};
  constexpr Colour kLow{0.86F, 0.90F, 0.91F};
  return height < 0.55F ? mix(kTop, kMiddle, height / 0.55F)
                        : mix(kMiddle, kLow, (height - 0.55F) / 0.45F);
}

// Flat clouds near the horizon, high ones above. `x`, `y` in px of a frame 540 px high.
float thickness(float x, float y, std::uint64_t seed) {
  const float low = y / Sky::kHorizon;
  const float down = y * (1 + 0.9F * low);
  const float shape = rough_noise(x * 0.0075F, down * 0.0135F, 6, seed);
  const float cover = rough_noise(x * 0.0022F, down * 0.004F, 2, seed + 50);
  return smooth_step(0.50F, 0.74F, shape * 0.62F + cover * 0.46F);
}

struct Cloud {
  float thickness;
  float light;
};

// At each kCloudStep px; clouds are soft.
constexpr int kCloudStep = 4;

std::vector<Cloud> sample_clouds(int columns, int rows, float scale, std::uint64_t seed) {
  std::vector<Cloud> clouds;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const float x = static_cast<float>(i * kCloudStep) / scale;
      const float y = static_cast<float>(j * kCloudStep) / scale;
      const float here = thickness(x, y, seed);
      const float to_sun = thickness(x - 14, y - 16, seed);
      clouds.push_back(
          {here, std::clamp(0.95F - 0.62F * to_sun + 0.30F * (here - to_sun), 0.0F, 1.0F)});
    }
  return clouds;
}

Texture make_clouds(int width, float scale, std::uint64_t seed) {
  const auto height = static_cast<int>(Sky::kHorizon * scale) + 2;
  const int columns = width / kCloudStep + 2;
  const std::vector<Cloud> clouds = sample_clouds(columns, height / kCloudStep + 2, scale, seed);
  Texture sky{width, height, {}};
  for (int y = 0; y < height; ++y) {
    const Colour clear = clear_sky(static_cast<float>(y) / scale / Sky::kHorizon);
    const float down = static_cast<float>(y % kCloudStep) / kCloudStep;
    for (int x = 0; x < width; ++x) {
      const float right = static_cast<float>(x % kCloudStep) / kCloudStep;
      const Cloud *upper =
          &clouds[static_cast<std::size_t>(y / kCloudStep) * columns + x / kCloudStep];
      const Cloud *lower = upper + columns;
      const auto between = [&](float Cloud::*value) {
        return mix(mix(upper->*value, upper[1].*value, right),
                   mix(lower->*value, lower[1].*value, right), down);
      };
      const Colour cloud =
          mix({0.66F, 0.71F, 0.78F}, {1.0F, 0.985F, 0.96F}, between(&Cloud::light));
      sky.pixels.push_back(unpack(opaque(mix(clear, cloud, 0.92F * between(&Cloud::thickness)))));
    }
  }
  return sky;
}

// Three ridges, each nearer one darker and less blue, with trees.
Texture make_hills(int width, int height, float scale, std::uint64_t seed) {
  Drawing drawing(width, height);
  cairo_t *cairo = drawing.get();
  constexpr Colour kRidges[] = {
      {0.60F, 0.70F, 0.76F}, {0.44F, 0.56F, 0.56F}, {0.27F, 0.38F, 0.27F}};
  Random random(seed);
  for (int ridge = 0; ridge < 3; ++ridge) {
    const float base = 36 + 22 * static_cast<float>(ridge);
    const auto top_at = [&](float x) {
      return scale * (base + (64 - 14 * static_cast<float>(ridge)) *
                                 (0.5F - rough_noise(x * 0.004F + 9.0F * static_cast<float>(ridge),
                                                     0.5F, 3, seed + 7)));
    };
    drawing.set(kRidges[ridge]);
    cairo_move_to(cairo, 0, height);
    for (int x = 0; x <= width; x += 4)
      cairo_line_to(cairo, x, static_cast<double>(top_at(static_cast<float>(x) / scale)));
    cairo_line_to(cairo, width, height);
    cairo_fill(cairo);
    const int trees = ridge == 0 ? 0 : ridge == 1 ? 1500 : 3000;
    for (int i = 0; i < trees; ++i) {
      const float x = random.between(0, static_cast<float>(width) / scale);
      if (noise(x * 0.013F, static_cast<float>(ridge), seed + 3) < 0.28F)
        continue;
      const float size = random.between(1.2F, 3.2F) * static_cast<float>(ridge);
      const float y = random.between(-0.7F, 1.2F) * size;
      const float shade = random.between(0.86F, 1.10F) - 0.08F * y / size;
      drawing.set(kRidges[ridge] * shade);
      cairo_arc(cairo, static_cast<double>(x * scale), static_cast<double>(top_at(x) + y * scale),
                static_cast<double>(size * scale * 0.8F), 0, 6.3);
      cairo_fill(cairo);
    }
  }
  return drawing.texture();
}

} // namespace

Sky::Sky(int width, int height, float scale, std::uint64_t seed)
    : scale_(scale),
      clouds_(make_clouds(width + static_cast<int>(kDrift * kLongest * scale), scale, seed)),
      hills_(make_hills(width + 2, height - static_cast<int>(kHillsTop * scale), scale, seed)) {}

void Sky::draw(Canvas &canvas, double time, double interval) const {
  const auto width = static_cast<std::size_t>(canvas.width());
  const std::vector<std::uint16_t> gain(width, 256);
  const std::vector<float> still(width, 0);
  const auto top = static_cast<int>(kHillsTop * scale_);
  for (int y = 0; y < hills_.height; ++y)
    canvas.draw_row(hills_.row(y), hills_.width, top + y, {still, still, 0, 0}, gain);
  // Beyond the end of the clouds they stand still.
  const float length = static_cast<float>(clouds_.width) - static_cast<float>(canvas.width()) - 2;
  const auto moved = [&](double t) {
    return std::clamp(kDrift * scale_ * static_cast<float>(t), 0.0F, length);
  };
  const std::vector<float> now(width, moved(time));
  const std::vector<float> before(width, moved(time - interval));
  for (int y = 0; y < clouds_.height; ++y)
    canvas.draw_row(clouds_.row(y), clouds_.width, y, {now, before, 1, length}, gain);
}

} // namespace film
