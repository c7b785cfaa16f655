// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/layer-frame.hpp"

#include "layers/layer-kernels.hpp"

namespace haptic {
namespace {

const HalfKernel<1> &small_blur() {
  static const auto kernel = gaussian<1>(0.55F);
  return kernel;
}

} // namespace

float smoothed_noise() {
  const HalfKernel<1> &kernel = small_blur();
  const float row = kernel[0] * kernel[0] + 2 * kernel[1] * kernel[1];
  return row * row;
}

void prepare(const LumaView &view, const LayerSize &size, float noise, LayerFrame &frame) {
  static const auto kSlow = gaussian<4>(1.5F); // cells
  load_luma(view, size, frame.luma);
  pool(frame.luma, size, frame.mean);
  CellMap slow = frame.mean;
  blur(kSlow, size, slow);
  PixelMap slow_pixels;
  widen(slow, size, slow_pixels);
  frame.smooth = frame.luma;
  blur(small_blur(), size, frame.smooth);
  find_slope(slow_pixels, size, frame);
  find_flat_cells(9 + 1.2F * noise, size, frame);
}

} // namespace haptic
