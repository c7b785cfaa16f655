// SPDX-License-Identifier: LGPL-2.1-or-later
// The haptic devices of this machine.
#pragma once

#include <string>
#include <vector>

namespace haptic {

struct FoundDevice {
  std::string name;    ///< for people
  std::string device;  ///< value of hapticsink's property `device` that opens it
  std::string problem; ///< reason and cure if it cannot be used; empty: it can
};

/// Returns SPIDARs on USB, then joysticks and wheels with force feedback; not the simulated one. A
/// SPIDAR that no program uses is opened for a moment to read its rotary switch
/// (spidar::list_usb()).
std::vector<FoundDevice> list_devices();

} // namespace haptic
