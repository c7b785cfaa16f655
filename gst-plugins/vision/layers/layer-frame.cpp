// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/layer-frame.hpp"

#include "layers/layer-kernels.hpp"

#include <cmath>

namespace haptic {
namespace {

const HalfKernel<1> &small_blur() {
  static const auto kernel = gaussian<1>(0.55F);
  return kernel;
}

} // namespace

const HalfKernel<kWindowRadius> &foreground_window() {
  // With the mean over a block, the variance of a Gaussian of sigma 1.9 px that ends after 4 px.
  static const auto kernel = gaussian<kWindowRadius>(0.87F);
  return kernel;
}

float smoothed_noise() {
  const HalfKernel<1> &kernel = small_blur();
  const float row = kernel[0] * kernel[0] + 2 * kernel[1] * kernel[1];
  return row * row;
}

// Between two pixels, a mean of both: (1 - part) * one + part * other.
float noise_left(Displacement by) {
  const HalfKernel<1> &kernel = small_blur();
  const float alike = 2 * kernel[0] * kernel[1] / std::sqrt(smoothed_noise());
  const auto along = [alike](float moved) {
    const float part = moved - std::floor(moved);
    return 1 - 2 * part * (1 - part) * (1 - alike);
  };
  return along(by.x) * along(by.y);
}

void find_structure(const LayerSize &size, float noise, LayerFrame &frame) {
  static const auto kSlow = gaussian<4>(1.5F); // cells
  static const DescriptionKernels kKernels = {small_blur(), foreground_window()};
  CellMap slow;
  blur(kSlow, size, frame.mean, slow);
  describe(slow, kKernels, 9 + 1.2F * noise, size, frame);
}

void prepare(const LumaView &view, const LayerSize &size, float noise, LayerFrame &frame) {
  load_luma(view, size, frame);
  find_structure(size, noise, frame);
}

} // namespace haptic
