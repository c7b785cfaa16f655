// SPDX-License-Identifier: LGPL-2.1-or-later
// The size of the region that a hand feels, for the tracker and for the player of fields.
#pragma once

namespace haptic {

/// Smallest side of a region whose motion can be measured, px.
inline constexpr int kSmallestRegion = 12;

/// Side of the region at a frame width, both px: 30 px in a frame 352 px wide (paper, 3.2.1).
int default_region_side(int frame_width) noexcept;

/// Returns the factor by which the hand's z changes the side: 1 at z = 0, doubled for each quarter
/// of the workspace towards the user, halved away from the user. `z` is that of the pointer event,
/// -1..1 of the half workspace.
double region_growth(double z) noexcept;

/// Returns `base` times that factor, at least the smallest region and at most half of the frame,
/// but `base` itself whatever it is; px.
double region_side(double z, double base, double frame_width, double frame_height) noexcept;

} // namespace haptic
