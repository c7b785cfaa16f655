// SPDX-License-Identifier: LGPL-2.1-or-later
// From a motion per frame to a motion at any time: straight lines between the middles of the
// intervals that the velocities were measured over.
#pragma once

#include "motion/field-hold.hpp"
#include "motion/timed-motion.hpp"
#include "non-blocking.hpp"
#include "samples/pointer-position.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// The motion at one time.
struct MotionAt {
  MotionSample sample;   ///< interpolated; while nothing is measured, the last motion
  bool measured = false; ///< false also before the first sample
  bool cut = false;      ///< a cut was passed since the call before
  double age = 0;      ///< s since the newest frame was due (or came, if later); 0 before the first
  double interval = 0; ///< s, of the newest measurement
  HeldAt held;         ///< whether or not anything is measured
};

/// A velocity is known when its interval is over, and a line to it needs the next one. A frame that
/// comes 1.5 intervals before it is due is felt when it is seen; one that comes when it is due, 1.5
/// intervals later. Neither makes a step: a motion that comes too late is reached over an interval
/// from its arrival. A held thing is where its velocity takes it: in the middle of an interval it
/// is half way between its places in the two frames. That it is let go or lost
/// is known at once, whenever the frame is seen. One thread; real-time safe; times in ns of one
/// steady clock, which may jump.
class MotionInterpolator {
public:
  static constexpr std::size_t kCapacity = 128; ///< more than a second ahead at 120 frames/s
  static_assert(kCapacity < FieldPool::kSlots);

  void add(TimedMotion motion, std::int64_t now) noexcept HAPTIC_NONBLOCKING;
  /// Returns the motion at `now`; in fields at `place` of the frame, or of the thing that was there
  /// when the place began to be pressed.
  const MotionAt &at(std::int64_t now,
                     const PointerPosition &place = {}) noexcept HAPTIC_NONBLOCKING;
  /// Discards everything that was added.
  void clear() noexcept;

private:
  TimedMotion &pending(std::size_t i) noexcept { return pending_[(first_ + i) % kCapacity]; }
  void pop_front(double z) noexcept;
  MotionSample motion_from(const PointerPosition &place) const noexcept;
  MotionSample motion_to(const TimedMotion &motion, const PointerPosition &place) const noexcept;
  void interpolate_to_next(std::int64_t now, const PointerPosition &place) noexcept;
  void rescale_all_to(const MotionSample &sample) noexcept;
  void follow_thing(std::int64_t now) noexcept;

  std::array<TimedMotion, kCapacity> pending_; // ring, in order of time
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  TimedMotion from_; // the line begins here
  FieldHold hold_;   // at the field of from_
  MotionAt now_;
  HeldPath path_;
  HeldPlace newest_held_;         // of the newest frame
  std::uint64_t order_ = 0;       // of the newest frame
  std::uint64_t let_go_ = 0;      // order of the newest frame in which nothing is held
  std::uint64_t thing_since_ = 0; // ns, HeldPlace::time of from_
  std::int64_t known_until_ = 0;  // ns, when the newest frame is due
  bool begun_ = false;
  bool cut_ = false; // was passed since at() was called
};

} // namespace haptic
