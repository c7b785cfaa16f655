// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion of a field under the hand.
#pragma once

#include "samples/motion-field.hpp"
#include "samples/pointer-position.hpp"

namespace haptic {

/// Returns a sample without a motion that holds what is the same everywhere in the field.
MotionSample frame_of(const MotionField &field) noexcept;

/// Returns the motion under the hand at `place`, as velocityavg would have measured it there, in a
/// square region whose side follows z (region_side()). Linear between the centres of cells. In a
/// region larger than 1.7 cells it is a mean that is as wide as that over the region; a part of the
/// region outside the frame does not count.
/// Cells weigh by their confidence, and the confidence is the mean of theirs. Spin and divergence
/// are 0: at the border of an object a field has a gradient, but nothing turns there. Real-time
/// safe. The field must be valid.
MotionSample sample_field(const MotionField &field, const PointerPosition &place) noexcept;

} // namespace haptic
