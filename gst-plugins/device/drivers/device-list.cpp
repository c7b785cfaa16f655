// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/device-list.hpp"

#if HAVE_EVDEV
#include "drivers/evdev-list.hpp"
#endif

#include <spidar/usb.hpp>

namespace haptic {
namespace {

std::vector<spidar::UsbUnit> spidars() {
  try {
    return spidar::list_usb();
  } catch (const spidar::Error &) {
    return {}; // where USB cannot be used there is none
  }
}

} // namespace

std::vector<FoundDevice> list_devices() {
  std::vector<FoundDevice> devices;
  for (const spidar::UsbUnit &unit : spidars()) {
    FoundDevice found{"SPIDAR-G, " + unit.model + " at USB port " + unit.port, "usb", ""};
    if (unit.switch_at) {
      const std::string id = std::to_string(*unit.switch_at);
      found.name += ", rotary switch " + id;
      found.device += ":" + id;
    }
    if (unit.problem)
      found.problem = unit.problem->what();
    devices.push_back(std::move(found));
  }
#if HAVE_EVDEV
  for (const EvdevUnit &unit : list_evdev().with_force)
    devices.push_back({unit.name, "evdev:" + unit.path, ""});
#endif
  return devices;
}

} // namespace haptic
