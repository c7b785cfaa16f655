// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether anything moved between two frames, or within one, from differences of pixels alone.
#pragma once

#include "pixels/luma-view.hpp"

namespace haptic {

enum class Change {
  none,   ///< a motion would have been seen
  unseen, ///< no more than noise, but so little texture that it could hide a motion
  some,   ///< something moved, or more than noise changed
};

struct ChangeFinding {
  Change change = Change::none;
  float energy = 0; ///< mean squared difference about its mean, grey levels squared
};

/// Returns `some` if the differences are larger than noise (variance of a pixel), or correlated
/// with the gradients as a translation makes them. The views have one size, at least 3x3.
ChangeFinding find_change(const LumaView &previous, const LumaView &current, float noise);

/// Whether neighbouring rows show different times, as in a frame woven from two fields. `noise`:
/// variance of a pixel. The view is at least 8x3.
bool is_combed(const LumaView &view, float noise);

} // namespace haptic
