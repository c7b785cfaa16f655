// SPDX-License-Identifier: LGPL-2.1-or-later
// The USB controllers as spidar::Controller. Threads as there.
#pragma once

#include "spidar/controller.hpp"
#include "usb/usb-link.hpp"

namespace spidar {

enum class UsbModel { simple, sh4 };

const char *name_of(UsbModel model) noexcept;

/// Whether a word pulls more than its rest word, by more than the D/A rounds.
bool is_force(const DacWords &words, const DacWords &rest) noexcept;

/// A controller whose rotary switch is known.
class UsbController : public Controller {
public:
  virtual int rotary_switch() const noexcept = 0;
  /// Sets direction and zero of the counters, where the model can. False if it did not take it.
  virtual bool reset() noexcept = 0;
};

/// Makes the controller and reads its rotary switch. Throws Error (io).
std::unique_ptr<UsbController> make_usb_controller(UsbModel model, std::unique_ptr<UsbLink> link);

} // namespace spidar
