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
};

struct EvdevUnits {
  std::vector<EvdevUnit> with_force; ///< a stick or wheel, and a force that can be held
  std::vector<EvdevUnit> without;    ///< sticks and wheels only
};

/// In the order of their numbers. Looks only at what everybody may read, opens nothing.
EvdevUnits list_evdev(const std::filesystem::path &input_class = "/sys/class/input");

} // namespace haptic
