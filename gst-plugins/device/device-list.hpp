// SPDX-License-Identifier: LGPL-2.1-or-later
// The haptic devices of this machine.
#pragma once

#include <string>
#include <vector>

namespace haptic {

struct FoundDevice {
  std::string name;    ///< for people
  std::string device;  ///< what hapticsink's property `device` says to open it
  std::string problem; ///< why it cannot be used, and the remedy; empty: it can
};

/// SPIDARs on USB, then joysticks and wheels with force feedback; not the simulated one. A SPIDAR
/// that nobody uses is opened for a moment to read its rotary switch (spidar::list_usb()).
std::vector<FoundDevice> list_devices();

} // namespace haptic
