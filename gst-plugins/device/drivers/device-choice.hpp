// SPDX-License-Identifier: LGPL-2.1-or-later
// Opens the device that the properties `device`, `geometry` and `sim-hand` choose.
#pragma once

#include <memory>
#include <spidar/geometry.hpp>
#include <spidar/haptic-device.hpp>
#include <string>

namespace haptic {

/// What a hand must do to feel a force.
enum class DeadMan {
  none,   ///< nothing
  button, ///< keep a button of the device pressed
};

struct DeviceChoice {
  std::string device = "auto"; ///< auto, sim, usb, usb:ID, evdev, evdev:PATH or none
  std::string geometry = spidar::kDefaultGeometry;
  std::string sim_hand = "hold:0,0,0"; ///< spidar::parse_hand_script()
  unsigned rate = 1000;                ///< Hz
  DeadMan dead_man = DeadMan::none;    ///< button: the device must have one

  bool operator==(const DeviceChoice &) const = default;
};

struct OpenedDevice {
  std::unique_ptr<spidar::HapticDevice> device; ///< null for `none`
  bool simulated_instead = false;               ///< `auto` found no hardware
};

/// Opens the device; may take a second, in which the strings are pulled taut. Throws spidar::Error,
/// with Cause::argument for an unknown `device`.
OpenedDevice open_device(const DeviceChoice &choice);

/// Opens a device again that open_device() has opened and that has gone since. Where the choice
/// names none (auto, usb, evdev), only that with this HapticDevice::identity() will do; a simulated
/// device does not replace a real one. Throws spidar::Error; not_found while it is away.
std::unique_ptr<spidar::HapticDevice> reopen_device(const DeviceChoice &choice,
                                                    const std::string &identity);

} // namespace haptic
