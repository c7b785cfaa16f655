// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/device-choice.hpp"

#include "format-text.hpp"
#include "messages.hpp"

#if HAVE_EVDEV
#include "drivers/evdev-device.hpp"
#include "drivers/evdev-list.hpp"
#endif

#include <optional>
#include <spidar/device.hpp>
#include <spidar/error.hpp>
#include <spidar/simulator.hpp>
#include <spidar/usb.hpp>

namespace haptic {
namespace {

// Returns the text after the prefix, or nothing if there is none.
std::optional<std::string> after(const std::string &prefix, const std::string &text) {
  if (text.starts_with(prefix) && text.size() > prefix.size())
    return text.substr(prefix.size());
  return std::nullopt;
}

[[noreturn]] void refuse_without_button(const std::string &description) {
  throw spidar::Error(spidar::Cause::argument,
                      format_text(messages::kNoButton, description.c_str()));
}

std::unique_ptr<spidar::HapticDevice> open_joystick([[maybe_unused]] const std::string &path,
                                                    [[maybe_unused]] const DeviceChoice &choice) {
#if HAVE_EVDEV
  return open_evdev(path, choice.dead_man == DeadMan::button);
#else
  throw spidar::Error(spidar::Cause::argument, messages::kNoJoysticksBuilt);
#endif
}

std::string path_of_evdev([[maybe_unused]] const std::string &identity) {
#if HAVE_EVDEV
  return find_evdev(identity);
#else
  return {};
#endif
}

std::unique_ptr<spidar::Controller> open_controller(const DeviceChoice &choice,
                                                    const spidar::Geometry &geometry,
                                                    bool &simulated_instead) {
  const std::string &device = choice.device;
  simulated_instead = device == "auto" && !spidar::usb_present();
  if (device == "sim" || simulated_instead)
    return std::make_unique<spidar::Simulator>(geometry, spidar::parse_hand_script(choice.sim_hand),
                                               1.0 / choice.rate);
  if (device == "auto" || device == "usb")
    return spidar::open_usb("");
  if (const auto id = after("usb:", device))
    return spidar::open_usb(*id);
  throw spidar::Error(spidar::Cause::argument,
                      format_text(messages::kUnknownDevice, device.c_str()));
}

} // namespace

OpenedDevice open_device(const DeviceChoice &choice) {
  OpenedDevice opened;
  const bool needs_button = choice.dead_man == DeadMan::button;
  if (choice.device == "none") {
    if (needs_button)
      refuse_without_button("device=none");
    return opened;
  }
  const auto path = after("evdev:", choice.device);
  if (path || choice.device == "evdev") {
    opened.device = open_joystick(path.value_or(""), choice);
    return opened;
  }
  const spidar::Geometry geometry = spidar::load_geometry(choice.geometry);
  auto controller = open_controller(choice, geometry, opened.simulated_instead);
  if (needs_button && !geometry.button && choice.device != "sim" && !opened.simulated_instead)
    refuse_without_button(controller->description());
  opened.device =
      std::make_unique<spidar::Device>(std::move(controller), geometry, 1.0 / choice.rate);
  return opened;
}

std::unique_ptr<spidar::HapticDevice> reopen_device(DeviceChoice choice,
                                                    const std::string &identity) {
  const bool any_evdev = choice.device == "evdev";
  const bool any_usb = choice.device == "auto" || choice.device == "usb";
  if (!any_evdev && !any_usb)
    return open_device(choice).device;
  const auto away = [&] {
    return spidar::Error(spidar::Cause::not_found,
                         format_text(messages::kDeviceIsAway, identity.c_str()));
  };
  if (any_evdev) {
    const std::string path = path_of_evdev(identity);
    if (path.empty())
      throw away();
    choice.device = "evdev:" + path;
  } else if (const std::size_t colon = identity.rfind(':'); colon != std::string::npos) {
    choice.device = "usb" + identity.substr(colon); // its rotary switch
  } else {
    choice.device = "usb"; // a run before this one never had it
  }
  auto device = open_device(choice).device;
  if (!identity.empty() && device->identity() != identity)
    throw away();
  return device;
}

} // namespace haptic
