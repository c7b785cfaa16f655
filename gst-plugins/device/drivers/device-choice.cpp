// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/device-choice.hpp"

#include "drivers/driver-table.hpp"
#include "format-text.hpp"
#include "messages.hpp"

#include <spidar/error.hpp>
#include <spidar/usb.hpp>

namespace haptic {
namespace {

struct Named {
  const Driver &driver;
  std::string id; // "": the first one found
};

Named named(const std::string &device) {
  const std::size_t colon = device.find(':');
  for (const Driver &driver : drivers()) {
    if (device == driver.scheme)
      return {driver, ""};
    if (driver.has_ids && device.substr(0, colon) == driver.scheme && colon + 1 < device.size())
      return {driver, device.substr(colon + 1)};
  }
  throw spidar::Error(spidar::Cause::argument,
                      format_text(messages::kUnknownDevice, device.c_str()));
}

} // namespace

OpenedDevice open_device(const DeviceChoice &choice) {
  if (choice.device != "auto") {
    const auto [driver, id] = named(choice.device);
    return {driver.open(id, choice), false};
  }
  const bool simulated = !spidar::usb_present();
  return {named(simulated ? "sim" : "usb").driver.open("", choice), simulated};
}

// A device that the user has named is whichever has that name.
std::unique_ptr<spidar::HapticDevice> reopen_device(const DeviceChoice &choice,
                                                    const std::string &identity) {
  auto [driver, id] = named(choice.device == "auto" ? "usb" : choice.device);
  // Without an identity, a run before this one never had it.
  const bool has_one = driver.find && id.empty() && !identity.empty();
  const auto away = [&] {
    return spidar::Error(spidar::Cause::not_found,
                         format_text(messages::kDeviceIsAway, identity.c_str()));
  };
  if (has_one && (id = driver.find(identity)).empty())
    throw away();
  auto device = driver.open(id, choice);
  if (has_one && device->identity() != identity)
    throw away();
  return device;
}

} // namespace haptic
