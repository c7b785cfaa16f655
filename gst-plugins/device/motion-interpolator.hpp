// SPDX-License-Identifier: LGPL-2.1-or-later
// From a motion per frame to a motion at any time: straight lines between the middles of the
// intervals that the velocities were measured over.
#pragma once

#include "field-pool.hpp"
#include "motion-sample.hpp"
#include "pointer-position.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace haptic {

/// A motion of unknown time: it counts from when it comes.
inline constexpr std::int64_t kAtOnce = std::numeric_limits<std::int64_t>::min();

/// What is known of one frame.
struct TimedMotion {
  MotionSample sample;         ///< of a field only what frame_of() says
  bool measured = false;       ///< else the frame says only that nothing could be measured
  std::int64_t time = kAtOnce; ///< ns, the middle of the sample's interval
  FieldPool::Field field = {}; ///< null: the same motion everywhere
};

/// What the hand is to feel at one time.
struct MotionAt {
  MotionSample sample;   ///< interpolated; while nothing is measured, the last motion
  bool measured = false; ///< false also before the first sample
  bool cut = false;      ///< a cut was passed since the call before
  double age = 0;        ///< s since the newest frame was due (or came, if later); 0 before
  double interval = 0;   ///< s, of the newest measurement
};

/// A velocity is known only once its interval is over, and a line to it needs the one after:
/// whoever is told of a frame 1.5 intervals before it is due feels the motion when it is seen,
/// and who is told when it is due, 1.5 intervals later. Either way without a step: a motion that
/// comes too late is led to over an interval from when it came. One thread; real-time safe; times
/// in ns of one steady clock, which may jump.
class MotionInterpolator {
public:
  void add(TimedMotion motion, std::int64_t now) noexcept;
  /// At `place` of the frame, which matters in fields only.
  const MotionAt &at(std::int64_t now, const PointerPosition &place = {}) noexcept;
  /// As if nothing had ever come.
  void clear() noexcept;

private:
  static constexpr std::size_t kCapacity = 128; // more than a second ahead at 120 frames/s

  TimedMotion &pending(std::size_t i) noexcept { return pending_[(first_ + i) % kCapacity]; }
  void pop_front() noexcept;
  void lead_on(std::int64_t now, const PointerPosition &place) noexcept;
  void take_frame_of(const MotionSample &sample) noexcept;

  std::array<TimedMotion, kCapacity> pending_; // ring, in order of time
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  TimedMotion from_; // the line begins here
  MotionAt now_;
  std::int64_t known_until_ = 0; // ns, when the newest frame is due
  bool begun_ = false;
};

} // namespace haptic
