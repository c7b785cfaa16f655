// SPDX-License-Identifier: LGPL-2.1-or-later
// The kinds of devices that hapticsink can open. A new one is a row of the table.
#pragma once

#include "drivers/device-choice.hpp"
#include "drivers/device-list.hpp"

#include <memory>
#include <span>
#include <spidar/haptic-device.hpp>
#include <string>
#include <vector>

namespace haptic {

/// Opens what the property `device` calls SCHEME or SCHEME:ID.
struct Driver {
  const char *scheme;
  bool has_ids; ///< whether SCHEME:ID is one
  /// What is plugged in; null: it lists nothing.
  std::vector<FoundDevice> (*list)();
  /// `id` "": the first one found. May return null for no device. Throws spidar::Error.
  std::unique_ptr<spidar::HapticDevice> (*open)(const std::string &id, const DeviceChoice &choice);
  /// The ID under which the device with this identity() is plugged in now, "" if it is away; null:
  /// its devices cannot be unplugged.
  std::string (*find)(const std::string &identity);
};

std::span<const Driver> drivers() noexcept;

} // namespace haptic
