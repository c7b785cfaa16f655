// SPDX-License-Identifier: LGPL-2.1-or-later
// The joysticks and wheels with force feedback that the kernel knows.
#pragma once

#include "drivers/force-effect.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace haptic {

struct EvdevUnit {
  std::string path; ///< "/dev/input/event5"
  std::string name; ///< what it calls itself
  /// HapticDevice::identity(): bus, vendor, product, version, serial number if it has one, name.
  /// The path is another one each time it is plugged in.
  std::string identity;
};

struct EvdevUnits {
  std::vector<EvdevUnit> with_force; ///< a stick or wheel, and a force that can be held
  std::vector<EvdevUnit> without;    ///< sticks and wheels only
};

/// In the order of their numbers. Looks only at what everybody may read, opens nothing.
EvdevUnits list_evdev(const std::filesystem::path &input_class = "/sys/class/input");

/// Returns the path of the unit with force feedback that has this identity, the first of several
/// that are alike; empty if there is none.
std::string find_evdev(const std::string &identity,
                       const std::filesystem::path &input_class = "/sys/class/input");

} // namespace haptic
