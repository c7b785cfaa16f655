// The last stage before the device. Every force goes through it, whatever law it comes from.
#pragma once

#include <cstdint>
#include <spidar/types.hpp>

namespace haptic {

/// Reasons for silence, as bits. While any is set the force fades to zero, and it fades in again
/// when the last one goes.
enum Hold : std::uint32_t {
  kHoldClosed = 1 << 0,    ///< no device open
  kHoldPaused = 1 << 1,    ///< the element is not PLAYING
  kHoldFlushing = 1 << 2,  ///< a seek is going on; also until the force is zero
  kHoldEnded = 1 << 3,     ///< end of stream
  kHoldReleased = 1 << 4,  ///< the user said `release`; until `arm`
  kHoldOverspeed = 1 << 5, ///< the grip was let go; until `arm`
  kHoldFaulted = 1 << 6,   ///< the device does not answer; until `arm`
  kHoldLate = 1 << 7,      ///< the loop was held up; until the force is zero
  kHoldNoPose = 1 << 8,    ///< where the grip is cannot be told
  kHoldGap = 1 << 9,       ///< nothing was measured (set by the chain)
  kHoldStale = 1 << 10,    ///< no new sample came (set by the chain)
};

/// The holds that only `arm` ends.
inline constexpr std::uint32_t kLatches = kHoldReleased | kHoldOverspeed | kHoldFaulted;

/// Order: finite or nothing, holds and staleness (fade), confidence, slew limit, norm clamp. One
/// thread; real-time safe.
class SafetyChain {
public:
  struct Input {
    spidar::Vector3 wanted = spidar::Vector3::Zero(); ///< N, from the law
    bool measured = false;                            ///< the newest sample holds a measurement
    double confidence = 0;                            ///< 0..1, of the newest sample
    double age = 0;                                   ///< s since the newest sample came
    double interval = 0;     ///< s between the pictures it was measured from
    std::uint32_t holds = 0; ///< Hold
    double max_force = 0;    ///< N
    double slew_rate = 0;    ///< N/s
    double dt = 0;           ///< s since the step before
  };

  /// The force to command, N. Never longer than max_force (a lowered max_force is approached at
  /// the slew rate). An input that is not finite yields zero on this very step.
  spidar::Vector3 step(const Input &input) noexcept;

  /// The last step let nothing through.
  bool silent() const noexcept { return output_.isZero(0); }
  /// The last step took its force from the newest sample.
  bool listening() const noexcept { return listening_; }
  /// The last step met a number that is not finite.
  bool found_non_finite() const noexcept { return non_finite_; }

private:
  spidar::Vector3 silence() noexcept;
  spidar::Vector3 fade_out(std::uint32_t holds, double dt) noexcept;
  spidar::Vector3 follow(const Input &input) noexcept;

  spidar::Vector3 output_ = spidar::Vector3::Zero();   // N
  spidar::Vector3 accepted_ = spidar::Vector3::Zero(); // N, last wanted force worth trusting
  std::uint32_t holds_ = kHoldGap;                     // of the step before
  double envelope_ = 0;                                // 0..1
  double fade_left_ = 0;                               // s until zero, while held
  double fade_in_ = 0.05;                              // s from zero to full, when no longer held
  double gate_ = 0;                                    // 0..1, from the confidence
  bool listening_ = false;
  bool non_finite_ = false;
};

/// s without a new sample after which the force fades: three of the sample's own intervals, at
/// least 0.1 s, and never more than 2 s whatever the sample claims.
double stale_after(double interval) noexcept;

/// How far a confidence lets a force through: 0 up to 0.2, 1 from 0.5 on, linear between.
double confidence_gate(double confidence) noexcept;

} // namespace haptic
