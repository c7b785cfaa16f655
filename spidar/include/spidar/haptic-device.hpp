// SPDX-License-Identifier: LGPL-2.1-or-later
// Interface of a haptic device: it measures a pose and exerts a wrench. SI units; frame of
// types.hpp.
#pragma once

#include "spidar/device-limits.hpp"
#include "spidar/export.hpp"
#include "spidar/types.hpp"

#include <chrono>
#include <cstdint>
#include <string>

namespace spidar {

/// Result of one tick. A device leaves what it does not have as it is here.
struct DeviceState {
  Pose pose;
  Vector3 velocity = Vector3::Zero(); ///< m/s, low-passed
  Counts counts{};
  StringLengths lengths = StringLengths::Zero();
  Tensions tensions = Tensions::Zero(); ///< N, as last commanded, with the D/A's resolution
  Wrench realised;                      ///< what these tensions do at this pose
  bool feasible = true;                 ///< no more than 5 mN of the force is given up
  bool valid = false;                   ///< the pose was measured
  bool interrupted = false;             ///< the motors were put at rest: begin from zero
  bool slipping = false;                ///< a string has just slipped: pose and wrench are wrong
  bool slipped = false;                 ///< and it was so for 0.2 s; until calibrate()
  Vector3 angular_velocity = Vector3::Zero(); ///< rad/s, low-passed; frame of the workspace
  /// A button of the grip or stick. On a SPIDAR-G on USB the geometry names it, and it counts once
  /// it was seen released, so that a wrong pin that never changes is no button.
  bool pressed = false;

  // What happened to the grip since the last valid pose before this exchange: normally between the
  // last two exchanges, else over the whole gap. acted·moved + acted·turned is the work that the
  // strings did on the grip, J. Frame of the workspace.

  /// The mean of what the motors had in that time, of the words as the D/A rounds them, in the
  /// middle between the poses before and after. exchange() leaves words at the motors that act
  /// until the next one; minimum tension counts for both where this device was interrupted.
  Wrench acted;
  /// m and rad (rotation vector); not low-passed. Zero if this pose is not valid or continues no
  /// other: the first one, after calibrate(), after a move that nobody saw.
  Vector3 moved = Vector3::Zero();
  Vector3 turned = Vector3::Zero();

  Wrench given_up; ///< the commanded wrench without what the tensions are meant to do
};

/// Returns the monotonic clock, ns: what exchange() is called with.
inline std::int64_t monotonic_time() noexcept {
  // steady_clock is CLOCK_MONOTONIC.
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The longest time between two exchanges under a force. The guardian of a SPIDAR-G puts the motors
/// at rest after it; who is later must begin from zero.
inline constexpr std::chrono::milliseconds kLongestSilence{10};

/// Not thread-safe: call exchange(), command() and calibrate() from one thread, everything else
/// before that thread starts or after it has ended.
class SPIDAR_API HapticDevice {
public:
  virtual ~HapticDevice() = default; ///< leaves no force behind

  /// One tick at `now` (ns, monotonic): sends the last command, receives the pose. Velocities are
  /// changes of the pose by the time between two calls, however late they come. False if the
  /// device did not answer; the state then keeps its last pose with valid = false. Real-time safe.
  virtual bool exchange(std::int64_t now) noexcept = 0;

  /// False if no exchange will succeed any more (unplugged, guardian dead): make another object.
  virtual bool connected() const noexcept = 0;

  /// The wrench that the next exchange sends, within the device's limits. One that is not finite
  /// counts as zero. Real-time safe.
  virtual void command(const Wrench &wrench) noexcept = 0;

  /// The next exchange leaves the device as it is left behind: a SPIDAR-G with minimum tension in
  /// each string. Off the centre that is not what command({}) sends, which balances the strings.
  /// Call it before the exchanges stop: only after this may they stay away. Real-time safe.
  virtual void rest() noexcept { command({}); }

  /// Takes the present grip position as workspace centre and identity orientation. Real-time safe.
  virtual void calibrate() noexcept = 0;

  virtual const DeviceState &state() const noexcept = 0;

  /// m from the centre; equation 1 maps it to the frame.
  virtual const Vector3 &workspace_half() const noexcept = 0;

  /// What it can do and hold. Laws, loop and safety chain go by it; it stays the same.
  virtual const DeviceLimits &limits() const noexcept = 0;

  /// Whether nothing is to be felt for now. Exactly no force needs unequal tensions off the centre,
  /// and these turn a grip that nobody holds. So a SPIDAR-G then goes to minimum tension within
  /// 0.1 s, and a command comes on top of what that has. Real-time safe.
  virtual void let_rest(bool /*rests*/) noexcept {}

  /// Limits the torque that comes with a force without being wanted, N·m: the force is reduced
  /// until it keeps within. Real-time safe.
  virtual void limit_side_torque(double /*limit*/) noexcept {}

  /// For messages: model, identity, connection.
  virtual std::string description() const = 0;

  /// What its user should know before a hand holds it, with the cure. Empty if nothing.
  virtual std::string remark() const { return {}; }

  /// What finds this unit again among others after it was unplugged. Empty if nothing does.
  virtual std::string identity() const { return {}; }
};

} // namespace spidar
