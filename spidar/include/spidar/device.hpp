// SPDX-License-Identifier: LGPL-2.1-or-later
// A SPIDAR-G as its user sees it: pose out, wrench in, limits kept.
#pragma once

#include "spidar/controller.hpp"
#include "spidar/export.hpp"
#include "spidar/geometry.hpp"
#include "spidar/haptic-device.hpp"

#include <memory>
#include <string>

namespace spidar {

class SPIDAR_API Device final : public HapticDevice {
public:
  /// Has the motors guarded against the end of this process (Controller::guard()), and starts with
  /// minimum tension in all strings. The centre is where the controller knows it to be
  /// (Controller::home()), else where the grip is once the strings are taut (calibrate()): within
  /// 1 s, normally 50 ms. `period` is the time between two calls of exchange(), s. Throws Error
  /// (geometry, argument, io).
  Device(std::unique_ptr<Controller> controller, Geometry geometry, double period = 0.001);
  ~Device() override; ///< leaves minimum tension behind

  bool exchange() noexcept override;
  bool connected() const noexcept override;
  /// Tensions for `wrench` at the present pose. They never leave the geometry's limits.
  void command(const Wrench &wrench) noexcept override;
  void calibrate() noexcept override;
  const DeviceState &state() const noexcept override;
  const Vector3 &workspace_half() const noexcept override;
  bool grip_is_free() const noexcept override { return true; }
  std::string description() const override;

  const Geometry &geometry() const noexcept;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace spidar
