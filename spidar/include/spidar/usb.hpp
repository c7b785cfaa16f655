// SPDX-License-Identifier: LGPL-2.1-or-later
// Lists and opens the controllers on USB. Not for the real-time thread.
#pragma once

#include "spidar/controller.hpp"
#include "spidar/error.hpp"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace spidar {

struct UsbUnit {
  std::string model; ///< "USB2.0 SH4"
  int bus = 0;
  int address = 0;
  std::string port;             ///< "1-2.3", as in the kernel's messages
  std::optional<int> switch_at; ///< rotary switch, where it could be read
  std::optional<Error> problem; ///< why it cannot be used, and the cure
};

/// Returns every controller found. Opens each that is not in use to read its switch, which sets the
/// motors of an SH4 to no tension. Throws Error (io) without USB.
SPIDAR_API std::vector<UsbUnit> list_usb();

/// Opens the controller whose rotary switch is at `id`, or the first one found if `id` is "".
/// Throws Error: not_found; permission, with the udev line; busy, with its holder; argument, if
/// `id` is no switch position or two controllers have it; io.
///
/// $SPIDAR_USB_ID adds a vendor and product: "04b4:8613=simple" or "=sh4".
SPIDAR_API std::unique_ptr<Controller> open_usb(const std::string &id);

/// How long an exchange may take: 2 ms, or $SPIDAR_USB_TIMEOUT (1..1000 ms) for a bus behind a
/// network or in an emulated machine. Throws Error (argument) if that is no such number.
SPIDAR_API std::chrono::milliseconds usb_exchange_timeout();

/// Whether a controller is plugged in. Opens none. Throws Error (argument) if $SPIDAR_USB_ID is
/// wrong.
SPIDAR_API bool usb_present();

} // namespace spidar
