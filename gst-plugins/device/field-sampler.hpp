// SPDX-License-Identifier: LGPL-2.1-or-later
// What of a motion field lies under the hand.
#pragma once

#include "motion-field.hpp"
#include "pointer-position.hpp"

namespace haptic {

/// What is the same everywhere in the field, as a sample without a motion.
MotionSample frame_of(const MotionField &field) noexcept;

/// The motion under the hand at `place`, in a region whose side follows its z (region_side()), as
/// velocityavg would have measured it there. Between the centres of cells it goes in straight
/// lines; a region larger than a cell is the mean over it; what of it lies outside of the frame
/// does not count. Cells weigh by their confidence, so that those that measured nothing add
/// nothing; the confidence is the mean of theirs. Spin and divergence are 0: across the border of
/// an object a field has a gradient, but nothing turns there. Real-time safe. The field must be
/// valid.
MotionSample sample_field(const MotionField &field, const PointerPosition &place) noexcept;

} // namespace haptic
