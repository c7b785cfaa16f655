// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/device-list.hpp"

#include "drivers/driver-table.hpp"

namespace haptic {

std::vector<FoundDevice> list_devices() {
  std::vector<FoundDevice> devices;
  for (const Driver &driver : drivers())
    if (driver.list)
      for (FoundDevice &found : driver.list())
        devices.push_back(std::move(found));
  return devices;
}

} // namespace haptic
