// SPDX-License-Identifier: LGPL-2.1-or-later
// The door for a program that commands a device itself: limits of force, torque, change and work,
// and a watch over the grip. The code is that of hapticsink, and docs/safety.md says what it
// promises. Units and frame as in haptic-device.hpp.
#pragma once

#include "spidar/export.hpp"
#include "spidar/haptic-device.hpp"

#include <cstdint>
#include <memory>

namespace spidar {

/// The limits that a program may change, with the defaults of hapticsink.
struct ForceLimits {
  static constexpr double kMostForce = 5;       // N
  static constexpr double kMostTorque = 0.1;    // N·m
  static constexpr double kLeastSlewRate = 0.1; // N/s
  static constexpr double kMostSlewRate = 1000; // N/s
  static constexpr double kMostDamping = 10;    // N·s/m
  /// Hand speeds up to this one are not damped, so that a hand that points feels the force alone.
  static constexpr double kUndamped = 0.1; // m/s

  double force = 1;            ///< N, 0 to kMostForce
  double torque = 0.02;        ///< N·m, 0 to kMostTorque
  double continuous_force = 1; ///< N rms over any minute, 0 to kMostForce; 0: no limit
  double slew_rate = 20;       ///< N/s, kLeastSlewRate to kMostSlewRate; the torque's at 0.02 m
  double damping = 1;          ///< N·s/m, against a grip above kUndamped, 0 to kMostDamping

  /// Whether each limit is in its range.
  constexpr bool are_possible() const noexcept {
    const auto within = [](double value, double least, double most) {
      return value >= least && value <= most; // not if it is NaN
    };
    return within(force, 0, kMostForce) && within(torque, 0, kMostTorque) &&
           within(continuous_force, 0, kMostForce) &&
           within(slew_rate, kLeastSlewRate, kMostSlewRate) && within(damping, 0, kMostDamping);
  }
};

/// Not a HapticDevice, so that no loop that has the limits by itself can get them twice.
/// Call arm() and release() from any thread, everything else from the one that exchanges.
class SPIDAR_API LimitedDevice {
public:
  /// The parts that switch_off_safety() knows, as bits.
  enum Part : std::uint32_t {
    kSlew = 1 << 0,  ///< the limit of the change
    kWork = 1 << 1,  ///< the limit of the work on the hand
    kLetGo = 1 << 2, ///< the latch after the grip was let go
    kAll = ~0U,      ///< these, every other limit, every fade and every latch
  };

  /// `device` outlives this object. It is armed. `period`: s between two exchanges. Later than
  /// kLongestSilence after the one before, an exchange holds the force at zero, whatever the
  /// period.
  explicit LimitedDevice(HapticDevice &device, double period = 0.001);
  ~LimitedDevice();

  /// The wrench that the exchanges from the next one on approach, until the next call. One that is
  /// not finite counts as zero. Until the first call the device is left as it is. Real-time safe.
  void command(const Wrench &wrench) noexcept;

  /// HapticDevice::exchange() with the part of the command that the limits let through. A grip that
  /// was let go, three failures in a row and a device that is gone are latched: the force is off
  /// until arm(). Real-time safe.
  bool exchange(std::int64_t now) noexcept;

  /// Ends every latch. The force comes back from zero within 0.5 s. Let a person ask for it.
  void arm() noexcept;
  /// The force fades to zero within 50 ms, until arm().
  void release() noexcept;
  bool armed() const noexcept;

  /// Throws Error (argument) if they are not possible.
  void set_limits(const ForceLimits &limits);
  const ForceLimits &limits() const noexcept;

  /// Switches off these parts (Part), and no others: 0 switches all on. For an experiment whose
  /// own program, or a person at the power switch, stands in for them. With kAll the device gets
  /// each command as it is, but for release(). Real-time safe.
  void switch_off_safety(std::uint32_t parts) noexcept;
  std::uint32_t switched_off() const noexcept;

  /// Why the last exchange held the force at zero or faded it: bits of spidar_hold (spidar.h). The
  /// latches are those of now.
  std::uint32_t holds() const noexcept;
  /// What made the force less than the command: bits of spidar_limit (spidar.h).
  std::uint32_t limited_by() const noexcept;
  /// What the last exchange sent.
  const Wrench &wrench() const noexcept;

private:
  struct SPIDAR_HIDDEN Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace spidar
