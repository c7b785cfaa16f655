// SPDX-License-Identifier: LGPL-2.1-or-later
// What the trackers of a region and of a field share of the layers.
#pragma once

#include "layers/region-layers.hpp"
#include "patches/measurement.hpp"

namespace haptic {

inline constexpr float kLayerNoiseRate = 0.1F; ///< of NoiseEstimate
/// s, at a new place: until the first the layers say nothing, and from the second on they count
/// alone. Two textures that move in opposite directions then make no step.
inline constexpr float kWarm = 0.06F;
inline constexpr float kSettled = 0.18F;
/// s: few frames a second settle in as many frames as thirty do.
inline constexpr float kLongestStep = 1.0F / 30;

/// Whether a motion is less than noise (variance of a pixel) makes it, px: of a background that is
/// seen through noise, the memory drifts.
bool is_slow(Displacement motion, float noise);

/// Whether a tile shows a motion, or is known by what is around it.
bool is_seen(const LayerTile &tile);

/// Adds side x side tiles that cover the region, which lies in the crop of the layers. Adds none if
/// they show too little together. Returns the background's share of the region.
float add_tiles(const RegionLayers &layers, const Rectangle &region, int side,
                Measurement &measurement);

} // namespace haptic
