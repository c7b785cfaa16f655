// SPDX-License-Identifier: LGPL-2.1-or-later
// What anything that a hand holds can do: pose out, wrench in.
#pragma once

#include "spidar/export.hpp"
#include "spidar/types.hpp"

#include <string>

namespace spidar {

/// What one tick found and did. What a device does not have stays as it is here.
struct DeviceState {
  Pose pose;
  Vector3 velocity = Vector3::Zero(); ///< m/s, low-passed
  Counts counts{};
  StringLengths lengths = StringLengths::Zero();
  Tensions tensions = Tensions::Zero(); ///< N, as last commanded, with the D/A's resolution
  Wrench realised;                      ///< what these tensions do at this pose
  bool feasible = true;                 ///< the commanded wrench was within the limits
  bool valid = false;                   ///< the pose can be trusted
  bool interrupted = false; ///< since the exchange before, the guardian had put the motors at rest
};

/// Not thread-safe: exchange() and command() belong to one thread; everything else before that
/// thread starts or after it ended.
class SPIDAR_API HapticDevice {
public:
  virtual ~HapticDevice() = default; ///< leaves no force behind

  /// One tick: sends what was last commanded, receives the pose. False when the device did not
  /// answer; the state then keeps its last pose with valid = false. Real-time safe.
  virtual bool exchange() noexcept = 0;

  /// False when the device has gone for good (unplugged, its guardian dead): make another one.
  virtual bool connected() const noexcept = 0;

  /// The wrench that the next exchange sends, within the device's limits. One that is not finite
  /// counts as zero. Real-time safe.
  virtual void command(const Wrench &wrench) noexcept = 0;

  /// Takes the present grip position as workspace centre and identity orientation. Real-time safe.
  virtual void calibrate() noexcept = 0;

  virtual const DeviceState &state() const noexcept = 0;

  /// m from the centre; equation 1 maps it to the frame.
  virtual const Vector3 &workspace_half() const noexcept = 0;

  /// Whether a grip that is let go of flies through the air, so that one that is too fast must lose
  /// its force until the user has it again. A stick on a joint does not.
  virtual bool grip_is_free() const noexcept = 0;

  /// For people: model, identity, where it is connected.
  virtual std::string description() const = 0;
};

} // namespace spidar
