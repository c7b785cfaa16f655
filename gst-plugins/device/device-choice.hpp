// SPDX-License-Identifier: LGPL-2.1-or-later
// Opens what the properties `device`, `geometry` and `sim-hand` ask for.
#pragma once

#include <memory>
#include <spidar/geometry.hpp>
#include <spidar/haptic-device.hpp>
#include <string>

namespace haptic {

struct DeviceChoice {
  std::string device = "auto"; ///< auto, sim, usb, usb:ID, evdev, evdev:PATH or none
  std::string geometry = spidar::kDefaultGeometry;
  std::string sim_hand = "hold:0,0,0"; ///< spidar::parse_hand_script()
  unsigned rate = 1000;                ///< Hz

  bool operator==(const DeviceChoice &) const = default;
};

struct OpenedDevice {
  std::unique_ptr<spidar::HapticDevice> device; ///< null for `none`
  bool simulated_instead = false;               ///< `auto` found no hardware
};

/// May take a second (the strings are pulled taut). Throws spidar::Error, with Cause::argument
/// for a `device` that is none of these.
OpenedDevice open_device(const DeviceChoice &choice);

/// The device that open_device() has opened and that has gone since: what was on USB comes back on
/// USB or not at all. Throws spidar::Error.
std::unique_ptr<spidar::HapticDevice> reopen_device(DeviceChoice choice);

} // namespace haptic
