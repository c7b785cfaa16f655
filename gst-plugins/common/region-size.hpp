// SPDX-License-Identifier: LGPL-2.1-or-later
// How much of the frame a hand feels: the law that the tracker and the player of fields share.
#pragma once

namespace haptic {

/// Less of a region than this on either side is too little to say how it moves, px.
inline constexpr int kSmallestRegion = 12;

/// Side of the region at a frame width, both px: 30 px in a frame 352 px wide (paper, 3.2.1).
int default_region_side(int frame_width) noexcept;

/// The hand's third dimension: how far it is pulled towards the user chooses how much of the
/// frame it feels, the fruit or the tree. `z` is that of the pointer event, -1..1 of the half
/// workspace: 1 at 0, doubled for each quarter of the workspace towards the user, halved away from
/// him.
double region_growth(double z) noexcept;

/// `base` times that growth, bounded by what can be measured and by half of the frame; px.
double region_side(double z, double base, double frame_width, double frame_height) noexcept;

} // namespace haptic
