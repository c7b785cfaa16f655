// SPDX-License-Identifier: LGPL-2.1-or-later
// What the fields before and after say of a field.
#pragma once

#include "samples/motion-field.hpp"

namespace haptic {

/// Makes each cell of `now` that was measured half its own velocity and a quarter of each neighbour
/// in time, where that was measured, too. Errors of single frames fall, and nothing is late. Of
/// fields that are less frequent than 60 a second the neighbours count less, by the square, so that
/// a swing of 2 Hz loses 1 % of its amplitude at any rate, and one of 5 Hz 7 %. A field that is
/// marked (still, duplicate, cut, discontinuity), or has a marked neighbour, or one of another
/// grid, stays as it is.
void take_centred_mean(const MotionField &before, MotionField &now, const MotionField &after);

} // namespace haptic
