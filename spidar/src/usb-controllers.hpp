// SPDX-License-Identifier: LGPL-2.1-or-later
// The two controllers with a known protocol, behind the Controller interface.
#pragma once

#include "spidar/controller.hpp"
#include "usb-link.hpp"

namespace spidar {

enum class UsbModel { simple, sh4 };

const char *name_of(UsbModel model) noexcept;

/// A controller whose rotary switch is known.
class UsbController : public Controller {
public:
  virtual int rotary_switch() const noexcept = 0;
  /// Makes it ready for use. Until then the counters of another program's device stay as they are.
  virtual bool reset() noexcept = 0;
};

/// Reads the rotary switch. Throws Error (io).
std::unique_ptr<UsbController> make_usb_controller(UsbModel model, std::unique_ptr<UsbLink> link);

} // namespace spidar
