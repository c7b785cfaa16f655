// SPDX-License-Identifier: LGPL-2.1-or-later
// A joystick or wheel with force feedback under Linux: the stick is the pointer.
#pragma once

#include <memory>
#include <spidar/haptic-device.hpp>
#include <string>

namespace haptic {

/// Opens the input device at `path`, or the first one with force feedback if it is "". Throws
/// spidar::Error (not_found, permission, busy, argument for a device that exerts no force, or,
/// where one is needed, has no button that sets DeviceState::pressed, io).
///
/// A thread of its own calls the driver, whose calls may take long. An effect lasts a tenth of a
/// second, so that the force ends by itself when this process stands still; the kernel erases it
/// when the process ends. If exchange() is not called for a tenth of a second, the force is zero.
std::unique_ptr<spidar::HapticDevice> open_evdev(const std::string &path,
                                                 bool needs_button = false);

} // namespace haptic
