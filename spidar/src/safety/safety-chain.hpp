// SPDX-License-Identifier: LGPL-2.1-or-later
// The last stage before the device. Every force passes it, whatever law computed it.
#pragma once

#include "non-blocking.hpp"
#include "safety/continuous-force.hpp"
#include "safety/energy-account.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <spidar/device-limits.hpp>
#include <spidar/limited-device.hpp>
#include <spidar/types.hpp>
#include <string>

namespace haptic {

/// Reasons why the force is held at zero, as bits (column `hold` of the log). While any is set the
/// force fades to zero, and it fades in again when the last one ends. kHoldSpent only limits it.
enum Hold : std::uint32_t {
  kHoldClosed = 1 << 0,     ///< no device is open
  kHoldPaused = 1 << 1,     ///< the element is not PLAYING
  kHoldFlushing = 1 << 2,   ///< a seek is going on; also until the force is zero
  kHoldEnded = 1 << 3,      ///< end of stream
  kHoldReleased = 1 << 4,   ///< the user emitted `release`; until `arm`
  kHoldOverspeed = 1 << 5,  ///< the grip was let go; until `arm`
  kHoldFaulted = 1 << 6,    ///< the device does not answer; until `arm`
  kHoldLate = 1 << 7,       ///< the tick came too late; until the force is zero
  kHoldNoPose = 1 << 8,     ///< the pose of the grip is unknown
  kHoldGap = 1 << 9,        ///< nothing was measured (set by the chain)
  kHoldStale = 1 << 10,     ///< no new sample came (set by the chain)
  kHoldCut = 1 << 11,       ///< another scene began; until the force is zero
  kHoldSuspended = 1 << 12, ///< the machine slept; until `arm`
  kHoldNonFinite = 1 << 13, ///< a number was not finite; this step only (set by the chain)
  kHoldDeadMan = 1 << 14,   ///< `dead-man` is on and its button is not pressed
  kHoldSpent = 1 << 15,     ///< the budget for continuous force limits the force (set by the chain)
  kHoldSlipped = 1 << 16,   ///< a string slips, or has slipped: until it is calibrated
  kHoldShaking = 1 << 17,   ///< a law shook the hand; until `arm`
};

struct NamedBit {
  std::uint32_t bit;
  const char *name;
};
/// The names of the reasons for users, in the order of the bits.
inline constexpr std::array kHoldNames = {
    NamedBit{kHoldClosed, "closed"},       NamedBit{kHoldPaused, "paused"},
    NamedBit{kHoldFlushing, "flushing"},   NamedBit{kHoldEnded, "ended"},
    NamedBit{kHoldReleased, "released"},   NamedBit{kHoldOverspeed, "overspeed"},
    NamedBit{kHoldFaulted, "faulted"},     NamedBit{kHoldLate, "late"},
    NamedBit{kHoldNoPose, "no-pose"},      NamedBit{kHoldGap, "gap"},
    NamedBit{kHoldStale, "stale"},         NamedBit{kHoldCut, "cut"},
    NamedBit{kHoldSuspended, "suspended"}, NamedBit{kHoldNonFinite, "non-finite"},
    NamedBit{kHoldDeadMan, "dead-man"},    NamedBit{kHoldSpent, "spent"},
    NamedBit{kHoldSlipped, "slipped"},     NamedBit{kHoldShaking, "shaking"},
};

/// The names of these holds, with commas between them.
std::string names_of_holds(std::uint32_t holds);

/// The holds that only `arm` ends.
inline constexpr std::uint32_t kLatches =
    kHoldReleased | kHoldOverspeed | kHoldFaulted | kHoldSuspended | kHoldShaking;
/// Those of them that the user did not ask for.
inline constexpr std::uint32_t kFaults = kLatches & ~kHoldReleased;

/// So many failed exchanges in a row are a fault.
inline constexpr int kFailuresToFault = 3;

/// What made the force of a step less than what the law and the touch wanted, as bits.
enum Limit : std::uint32_t {
  kLimitFade = 1 << 0,       ///< a hold, or the way back from one
  kLimitConfidence = 1 << 1, ///< the confidence of the sample
  kLimitForce = 1 << 2,      ///< max_force
  kLimitTorque = 1 << 3,     ///< max_torque
  kLimitBudget = 1 << 4,     ///< continuous_force
  kLimitSlew = 1 << 5,       ///< slew_rate
  kLimitWork = 1 << 6,       ///< the work of the film on the hand
  kLimitEnergy = 1 << 7,     ///< the energy account: what the hand gets back
};
/// The names of the limits for users, in the order of the bits.
inline constexpr std::array kLimitNames = {
    NamedBit{kLimitFade, "fade"},     NamedBit{kLimitConfidence, "confidence"},
    NamedBit{kLimitForce, "force"},   NamedBit{kLimitTorque, "torque"},
    NamedBit{kLimitBudget, "budget"}, NamedBit{kLimitSlew, "slew"},
    NamedBit{kLimitWork, "work"},     NamedBit{kLimitEnergy, "energy"},
};

/// The force of touching a surface, or of a spring to a held thing, whose end then is the surface:
/// the hand has to put in what it gets back.
struct TouchForce {
  spidar::Vector3 force = spidar::Vector3::Zero(); ///< N, on the hand
  double surface_work = 0; ///< J, that the surface put into the spring since the step before
  /// J, of a held thing since the step before, that the counts of the hand's place hide.
  double hidden_work = 0;
  /// m, the way of a held thing since the step before; none if no thing carries the hand.
  std::optional<spidar::Vector3> carried;
  double energy = 0;   ///< J, of the whole spring
  double released = 0; ///< N, by the hand\'s own way out since the step before: not slew-limited
};

/// Order: finite or nothing, holds and staleness (fade), norm clamp, trust, budget for
/// continuous force, damping, slew limit, norm clamp, energy account, brake of the turning grip.
/// The slew limit delays what the law, its trust and the touch say, and no hold, lowered
/// maximum, end of a touch or of the energy. One thread; real-time safe.
class SafetyChain {
public:
  static constexpr double kUndamped = spidar::ForceLimits::kUndamped; // m/s
  /// Where fingers hold a grip: torques count as forces there.
  static constexpr double kTorqueArm = 0.02; // m

  struct Input {
    spidar::Wrench wanted;                             ///< N and N·m, from the law
    spidar::Vector3 of_hand = spidar::Vector3::Zero(); ///< N, of it: what the hand's motion changed
    TouchForce touch;                                  ///< beside it
    bool measured = false;                             ///< the newest sample holds a measurement
    double trust = 0;        ///< 0..1 of it is felt, by the confidence of the newest sample
    double age = 0;          ///< s since the newest sample came
    double interval = 0;     ///< s between the frames it was measured from
    std::uint32_t holds = 0; ///< Hold
    spidar::Vector3 hand_velocity = spidar::Vector3::Zero(); ///< m/s
    spidar::Vector3 hand_turning = spidar::Vector3::Zero();  ///< rad/s
    /// Since the step before: what the device did, and m and rad as measured, not low-passed
    spidar::Wrench acted;
    spidar::Vector3 moved = spidar::Vector3::Zero();
    spidar::Vector3 turned = spidar::Vector3::Zero();
    double max_force = 0;        ///< N
    double continuous_force = 0; ///< N rms over a minute; 0: any
    double max_torque = 0;       ///< N·m
    double slew_rate = 0;        ///< N/s; for the torque at kTorqueArm
    double damping = 0;          ///< N·s/m
    bool limits_work = true;     ///< of the film on the hand
    bool film_has_ended = false; ///< only what acts beside the law is measured
    double dt = 0;               ///< s since the step before
    double longest_dt = 0;       ///< s, the longest that may come

    /// What acts beside the law is certain: of the sum, the law fades with its own trust, and
    /// only `share` of it (0..1) is left. Where the law has no measurement, its part fades as it
    /// would alone.
    void make_certain(double share = 1) noexcept;
  };

  /// Without a device: of DeviceLimits{}.
  explicit SafetyChain(const spidar::DeviceLimits &device) noexcept : device_(device) {}
  /// The chain goes on with another device.
  void set_device(const spidar::DeviceLimits &device) noexcept { device_ = device; }

  /// Returns the wrench to command. Never more than max_force and max_torque; a lowered maximum is
  /// reached as fast as the whole force of the device falls in 50 ms, or at the slew rate if that
  /// is faster. An input that is not finite yields zero on this very step.
  spidar::Wrench step(const Input &input) noexcept HAPTIC_NONBLOCKING;

  /// Returns the result of the last step.
  const spidar::Wrench &wrench() const noexcept { return braked_; }
  /// Whether the torque of the last step, before the brake, turns the grip on in this direction.
  bool drives(const spidar::Vector3 &turning) const noexcept {
    return output_.torque.dot(turning) > 0;
  }
  /// N·m that may come with a force unasked: what turns a free grip under no force is no more than
  /// what minimum tension does in the workspace. A limit below that would take forces away, and by
  /// how much would change within a millimetre.
  double most_side_torque(const spidar::Vector3 &force, double max_torque) const noexcept {
    const double least = device_.side_torque;
    return std::clamp(max_torque, least, least + kTorqueArm * force.norm());
  }
  /// J that the hand may have back. A touch whose spring holds more than the account pays would be
  /// cut off on the hand's way out and felt on its way in: the force would go on and off.
  double energy_of_hand() const noexcept { return account_.of_hand() + lent_; }
  /// The pose of the hand is measured anew: of what the hand has put in, not all can be trusted.
  void calibrate() noexcept { account_.calibrate(); }
  /// The force begins anew, from zero. What is left of energy and continuous force is kept.
  void restart() noexcept;
  /// As new, but for what is left of energy and continuous force. The last command acted for
  /// `acted` s.
  void begin_run(double acted) noexcept;
  /// Nothing was commanded for so long, s.
  void rest(double seconds) noexcept;
  /// The last step commanded zero.
  bool silent() const noexcept { return output_.force.isZero(0) && output_.torque.isZero(0); }
  /// The last step had a measurement that is not stale.
  bool follows_sample() const noexcept { return follows_sample_; }
  /// Returns the reasons (Hold) why the last step held the force; 0 if it did not.
  std::uint32_t holds() const noexcept {
    return holds_ | (non_finite_ ? kHoldNonFinite : 0U) | (limited_ ? kHoldSpent : 0U);
  }
  /// Returns the limits (Limit) that acted in the last step.
  std::uint32_t limits() const noexcept { return limits_; }
  const ContinuousForce &continuous_force() const noexcept { return continuous_force_; }
  /// The input of the last step held a number that is not finite.
  bool found_non_finite() const noexcept { return non_finite_; }

private:
  // A command, before the brake.
  struct Parts {
    spidar::Wrench film;
    spidar::Vector3 hand = spidar::Vector3::Zero(); // N, what follows the hand

    spidar::Vector3 force() const noexcept { return film.force + hand; }
    bool limit_force(double limit) noexcept;
  };

  void silence() noexcept;
  void fade_out(std::uint32_t holds, double dt) noexcept;
  void follow(const Input &input) noexcept;
  void approach(const Parts &wanted, double step, const Input &input) noexcept;
  void account_for_energy(const Input &input) noexcept;
  void note_limit(bool acted, Limit limit) noexcept { limits_ |= acted ? limit : 0U; }

  spidar::DeviceLimits device_;
  Parts parts_;                    // of the last step
  Parts acting_;                   // of the step before it: what the device exerts until the next
  spidar::Wrench output_;          // sum of parts_
  spidar::Wrench braked_;          // the result
  Parts accepted_;                 // last wanted wrench worth trusting
  std::uint32_t holds_ = kHoldGap; // of the step before
  double envelope_ = 0;            // 0..1
  double fade_left_ = 0;           // s until zero, while held
  double fade_in_ = 0.05;          // s from zero to full, when no longer held
  double film_left_ = 0;           // s until the film's part is zero, once it has ended
  double gate_ = 0;                // 0..1, from the trust
  EnergyAccount account_;
  double lent_ = 0; // J, beyond what the purse holds, in the last step
  ContinuousForce continuous_force_;
  double force_limit_ = 0;   // N, that it leaves
  bool limited_ = false;     // the last step
  std::uint32_t limits_ = 0; // of the last step
  bool follows_sample_ = false;
  bool non_finite_ = false;
};

/// Returns v, or the part of it that is `limit` long.
inline spidar::Vector3 clamp_norm(const spidar::Vector3 &v, double limit) noexcept {
  const double norm = v.norm();
  return norm > limit ? spidar::Vector3(v * (limit / norm)) : v;
}

/// Returns the time without a new sample after which the force fades, s: three intervals of the
/// newest sample, at least 0.1 s and at most 2 s.
double stale_after(double interval) noexcept;

} // namespace haptic
