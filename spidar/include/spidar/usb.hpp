// SPDX-License-Identifier: LGPL-2.1-or-later
// The controllers on the USB bus: what is there, and opening one.
#pragma once

#include "spidar/controller.hpp"
#include "spidar/error.hpp"

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
  std::optional<Error> problem; ///< why it cannot be used, and the remedy
};

/// Every controller found. Each is opened for a moment to read its switch, which sets the motors of
/// an SH4 to no tension; one that a program uses is left alone. Throws Error (io) without USB.
SPIDAR_API std::vector<UsbUnit> list_usb();

/// `id` is the rotary switch, "" for the first one found. Throws Error (not_found, permission with
/// the udev line, busy with its holder, argument for an id that is none or that two have, io).
///
/// Which devices are SPIDAR-G is told by vendor and product. $SPIDAR_USB_ID adds another one:
/// "04b4:8613=simple" or "=sh4". An exchange may take 2 ms; $SPIDAR_USB_TIMEOUT, 1..1000 ms, is for
/// a bus behind a network or in an emulated machine: what fails is noticed that much later.
SPIDAR_API std::unique_ptr<Controller> open_usb(const std::string &id);

/// Whether there is a controller, without opening it.
SPIDAR_API bool usb_present() noexcept;

} // namespace spidar
