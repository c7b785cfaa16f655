// SPDX-License-Identifier: LGPL-2.1-or-later
// Opens the controller that a user names: usb, usb:ID or sim. For the C API and the tools.
#pragma once

#include "fail.hpp"
#include "spidar/simulator.hpp"
#include "spidar/usb.hpp"

namespace spidar {

/// `sim_hand` and `period` (s) are for sim. Throws Error.
inline std::unique_ptr<Controller> open_controller(const std::string &name,
                                                   const Geometry &geometry,
                                                   const std::string &sim_hand,
                                                   double period = 0.001) {
  if (name == "sim")
    return std::make_unique<Simulator>(geometry, parse_hand_script(sim_hand), period);
  if (name == "usb")
    return open_usb("");
  if (name.starts_with("usb:") && name.size() > 4)
    return open_usb(name.substr(4));
  fail(Cause::argument, messages::kToolDevice, name.c_str());
}

} // namespace spidar
