// SPDX-License-Identifier: LGPL-2.1-or-later
// A joystick or wheel with force feedback, as Linux knows it: the stick is the pointer.
#pragma once

#include <memory>
#include <spidar/haptic-device.hpp>
#include <string>

namespace haptic {

/// `path` is that of an input device; "" takes the first one with force feedback. `period` is the
/// time between two calls of exchange(), s. Throws spidar::Error (not_found, permission, busy,
/// argument for a device that exerts no force, io).
///
/// A thread of its own talks to the driver, which may take its time. The driver plays an effect for
/// a tenth of a second only, so that the force stops by itself when this process stands still, and
/// the kernel erases it when the process ends. If exchange() is not called for as long, the force
/// is taken off too.
std::unique_ptr<spidar::HapticDevice> open_evdev(const std::string &path, double period);

} // namespace haptic
