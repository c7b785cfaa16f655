// SPDX-License-Identifier: LGPL-2.1-or-later
// A SPIDAR-G: measures the pose of the grip, and exerts a wrench within the geometry's limits.
// Units, frame and threads as in haptic-device.hpp.
#pragma once

#include "spidar/controller.hpp"
#include "spidar/export.hpp"
#include "spidar/geometry.hpp"
#include "spidar/haptic-device.hpp"
#include "spidar/layout.hpp"

#include <cstdint>
#include <memory>
#include <string>

namespace spidar {

/// What a SPIDAR-G of this geometry can do and hold.
SPIDAR_API DeviceLimits limits_of(const Geometry &geometry) noexcept;

class SPIDAR_API Device final : public HapticDevice {
public:
  /// Guards the motors (Controller::guard()), and sets minimum tension. The centre is that of
  /// Controller::home(), or else the place of the grip once the strings are taut: after 50 ms
  /// normally, 1 s at most. `period` is the time from here to the first call of exchange(), s.
  /// Throws Error (geometry, argument, io).
  Device(std::unique_ptr<Controller> controller, Geometry geometry, double period = 0.001);
  ~Device() override; ///< leaves minimum tension behind

  bool exchange(std::int64_t now) noexcept override;
  bool connected() const noexcept override;
  /// Computes the tensions for `wrench` at the present pose, in the order of TensionSolver.
  void command(const Wrench &wrench) noexcept override;
  void let_rest(bool rests) noexcept override;
  void limit_side_torque(double limit) noexcept override;
  void rest() noexcept override;
  void calibrate() noexcept override;
  const DeviceState &state() const noexcept override;
  const Vector3 &workspace_half() const noexcept override;
  const DeviceLimits &limits() const noexcept override;
  std::string description() const override;
  std::string remark() const override;
  std::string identity() const override;

  /// Controller::inputs().
  std::uint16_t inputs() const noexcept;

  /// As given, but with a tension_max that the largest word of each string reaches.
  const Geometry &geometry() const noexcept;

private:
  struct SPIDAR_HIDDEN Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace spidar
