// SPDX-License-Identifier: LGPL-2.1-or-later
// Holds a thing of a field track, or what moves about a place where there is none.
#pragma once

#include "non-blocking.hpp"
#include "samples/motion-field.hpp"
#include "samples/pointer-position.hpp"

namespace haptic {

/// Makes of the fields what roitracker and velocityavg would make of the frames under a press. The
/// web player computes the same in the same order, so that both give the same bits. One thread;
/// real-time safe; fields must be valid.
class FieldHold {
public:
  /// Takes the nearest thing of the field under a place, or what moves about the place.
  void press(const PointerPosition &place, const MotionField &field) noexcept HAPTIC_NONBLOCKING;

  /// The next field. `z`: of the hand, for the size of the region. `stretch`: what the velocities
  /// of the field were multiplied by.
  void step(const MotionField &field, double z = 0, double stretch = 1) noexcept HAPTIC_NONBLOCKING;

  /// Another scene began, or the fields that follow are of elsewhere in the film.
  void lose() noexcept;

  void release() noexcept { *this = {}; }

  bool is_pressed() const noexcept { return sample_.held.state != HoldState::none; }

  /// The motion of the last field, and the thing: right after the press, the motion at the place
  /// that was pressed.
  const MotionSample &sample() const noexcept { return sample_; }

private:
  void follow_thing(const MotionField &field, double z, float stretch) noexcept;
  void feel_region(const MotionField &field, double z) noexcept;
  void follow_region(const MotionField &field, double z, float stretch) noexcept;

  MotionSample sample_;
  bool is_thing_ = false;
  std::uint16_t id_ = 0; // of the thing
};

} // namespace haptic
