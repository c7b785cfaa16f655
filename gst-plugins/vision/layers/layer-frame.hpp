// SPDX-License-Identifier: LGPL-2.1-or-later
// What the layers need of one frame.
#pragma once

#include "layers/layer-kernels.hpp"
#include "layers/layer-maps.hpp"
#include "pixels/luma-view.hpp"

namespace haptic {

/// Variance that white noise of variance 1 has in `smooth`.
float smoothed_noise();

/// The part of that variance which is left in `smooth` between the pixels, displaced by `by`.
float noise_left(Displacement by);

/// The window in which the pixels that move share a displacement.
const HalfKernel<kWindowRadius> &foreground_window();

/// Fills in what luma and mean, which load_luma() fills in, say. `noise`: variance of a pixel.
void find_structure(const LayerSize &size, float noise, LayerFrame &frame);

/// Fills in the frame from a crop that fits into the size. `noise`: variance of a pixel.
void prepare(const LumaView &view, const LayerSize &size, float noise, LayerFrame &frame);

} // namespace haptic
