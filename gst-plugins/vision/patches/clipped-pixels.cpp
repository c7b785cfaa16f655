// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patches/clipped-pixels.hpp"

#include <algorithm>
#include <array>

namespace haptic {
namespace {

bool is_beyond(std::uint8_t grey, int level) {
  return level > 128 ? grey >= level : grey <= level;
}

// The limit that a quarter of a sample of the region has reached: that of 8 bits, or that of video
// range (ITU-R BT.601). -1 if there is none.
int clipped_level(const LumaView &view, const Area &region) {
  constexpr int kAlong = 10; // pixels of the sample in each direction
  constexpr std::array kLevels = {0, 16, 235, 255};
  std::array<int, kLevels.size()> counts{};
  for (int j = 0; j < kAlong; ++j)
    for (int i = 0; i < kAlong; ++i) {
      const auto at = [](float from, float length, int index, int available) {
        const float place = from + length * (static_cast<float>(index) + 0.5F) / kAlong;
        return std::clamp(static_cast<int>(place) + kSmoothingRadius, 0, available - 1);
      };
      const int x = at(region.x, region.width, i, view.width);
      const int y = at(region.y, region.height, j, view.height);
      const std::uint8_t grey = view.pixels[y * view.stride + x];
      for (std::size_t k = 0; k < kLevels.size(); ++k)
        counts[k] += grey == kLevels[k];
    }
  const auto most = std::ranges::max_element(counts);
  return 4 * *most < kAlong * kAlong ? -1
                                     : kLevels[static_cast<std::size_t>(most - counts.begin())];
}

} // namespace

void ClippedPixels::find(const LumaView &view, const Area &region) {
  // Smoothing mixes a pixel with its neighbours, a gradient with the next ones.
  constexpr int kReach = kSmoothingRadius + 1;
  forget();
  const int level = clipped_level(view, region);
  if (level < 0)
    return;
  width_ = view.width - 2 * kSmoothingRadius;
  height_ = view.height - 2 * kSmoothingRadius;
  marks_.assign(cell(height_, width_, 0), 0);
  for (int y = 0; y < view.height; ++y) {
    const std::uint8_t *row = view.pixels + y * view.stride;
    const std::uint8_t *end = row + view.width;
    const auto beyond = [&](std::uint8_t grey) { return is_beyond(grey, level); };
    for (const std::uint8_t *from = std::find_if(row, end, beyond); from != end;) {
      const std::uint8_t *to = std::find_if_not(from, end, beyond);
      const auto column = [&](std::ptrdiff_t x) {
        return std::clamp(static_cast<int>(x) - kSmoothingRadius, 0, width_);
      };
      const int first = column(from - row - kReach);
      const int last = column(to - row + kReach);
      const int middle = y - kSmoothingRadius;
      for (int j = std::max(0, middle - kReach); j <= std::min(height_ - 1, middle + kReach); ++j)
        std::fill(marks_.begin() + static_cast<std::ptrdiff_t>(cell(j, width_, first)),
                  marks_.begin() + static_cast<std::ptrdiff_t>(cell(j, width_, last)), 1);
      from = std::find_if(to, end, beyond);
    }
  }
}

bool ClippedPixels::is_kept(int x, int y) const {
  return x < 0 || y < 0 || x >= width_ || y >= height_ || marks_[cell(y, width_, x)] == 0;
}

// With the kept pixels W of a template, its zero-mean grey levels t and projected gradients g':
//   t <- t - mean over W of t
//   g' <- g' - mean over W of g' - a t,   a = sum over W of t g' / (sum over W of t^2 + r)
// and 0 outside of W. Offset and gain change t and g' by what 1 and t span, on W as on all pixels,
// so that this is the template of prepare_templates from the pixels of W alone.
void ClippedPixels::mask(Template &patch) const {
  constexpr float kLeastGrey = 1e-6F; // changes no sum
  const auto side = static_cast<std::size_t>(patch.side);
  const std::size_t pixels = side * side;
  std::array<std::uint16_t, Template::kMostPixels> kept;
  std::size_t count = 0;
  float grey = 0;
  Displacement gradient;
  for (std::size_t i = 0; i < pixels; ++i) {
    const int x = static_cast<int>(patch.x) + static_cast<int>(i) % patch.side;
    const int y = static_cast<int>(patch.y) + static_cast<int>(i) / patch.side;
    // Bilinear from four pixels.
    if (is_kept(x, y) && is_kept(x + 1, y) && is_kept(x, y + 1) && is_kept(x + 1, y + 1)) {
      kept[count++] = static_cast<std::uint16_t>(i);
      grey += patch.grey[i];
      gradient += {patch.gradient_x[i], patch.gradient_y[i]};
    } else {
      patch.grey[i] = patch.gradient_x[i] = patch.gradient_y[i] = 0;
    }
  }
  if (count == pixels)
    return;
  patch.seen = std::max(1.0F, static_cast<float>(count));
  patch.energy = 0;
  Displacement moment;
  for (const std::uint16_t i : std::span(kept).first(count)) {
    patch.grey[i] -= grey / patch.seen;
    // 0 stands for no weight.
    if (patch.grey[i] == 0)
      patch.grey[i] = kLeastGrey;
    patch.gradient_x[i] -= gradient.x / patch.seen;
    patch.gradient_y[i] -= gradient.y / patch.seen;
    patch.energy += patch.grey[i] * patch.grey[i];
    moment += patch.grey[i] * Displacement{patch.gradient_x[i], patch.gradient_y[i]};
  }
  const Displacement slope = 1 / (patch.energy + kEnergyRidge * patch.seen) * moment;
  patch.bias = kEnergyRidge * patch.seen * slope;
  patch.structure = {};
  for (const std::uint16_t i : std::span(kept).first(count)) {
    const float x = patch.gradient_x[i] -= slope.x * patch.grey[i];
    const float y = patch.gradient_y[i] -= slope.y * patch.grey[i];
    patch.structure += {x * x, x * y, y * y};
  }
  const float share = static_cast<float>(count) / static_cast<float>(pixels);
  patch.slope *= share;
  patch.curvature *= share;
}

} // namespace haptic
