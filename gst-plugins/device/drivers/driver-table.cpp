// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/driver-table.hpp"

#include "format-text.hpp"
#include "messages.hpp"

#if HAVE_EVDEV
#include "drivers/evdev-device.hpp"
#include "drivers/evdev-list.hpp"
#endif

#include <array>
#include <spidar/device.hpp>
#include <spidar/error.hpp>
#include <spidar/simulator.hpp>
#include <spidar/usb.hpp>
#include <utility>

namespace haptic {
namespace {

using Opened = std::unique_ptr<spidar::HapticDevice>;

[[noreturn]] void refuse_without_button(const std::string &description) {
  throw spidar::Error(spidar::Cause::argument,
                      format_text(messages::kNoButton, description.c_str()));
}

Opened open_none(const std::string & /*id*/, const DeviceChoice &choice) {
  if (choice.dead_man == DeadMan::button)
    refuse_without_button("device=none");
  return nullptr;
}

// ---- SPIDARs ------------------------------------------------------------------------------------

Opened open_simulated(const std::string & /*id*/, const DeviceChoice &choice) {
  const spidar::Geometry geometry = spidar::load_geometry(choice.geometry);
  const double period = 1.0 / choice.rate;
  return std::make_unique<spidar::Device>(
      std::make_unique<spidar::Simulator>(geometry, spidar::parse_hand_script(choice.sim_hand),
                                          period),
      geometry, period);
}

Opened open_spidar(const std::string &id, const DeviceChoice &choice) {
  const spidar::Geometry geometry = spidar::load_geometry(choice.geometry);
  auto controller = spidar::open_usb(id);
  if (choice.dead_man == DeadMan::button && !geometry.button)
    refuse_without_button(controller->description());
  return std::make_unique<spidar::Device>(std::move(controller), geometry, 1.0 / choice.rate);
}

std::vector<FoundDevice> list_spidars() {
  std::vector<spidar::UsbUnit> units;
  try {
    units = spidar::list_usb();
  } catch (const spidar::Error &error) {
    if (error.cause() == spidar::Cause::argument)
      return {{"SPIDAR-G", "usb", error.what()}};
    return {}; // where USB cannot be used there is none
  }
  std::vector<FoundDevice> devices;
  for (const spidar::UsbUnit &unit : units) {
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
  return devices;
}

// Its rotary switch. Whether it is there shows when it is opened.
std::string find_spidar(const std::string &identity) {
  return identity.substr(identity.rfind(':') + 1);
}

// ---- joysticks and wheels -----------------------------------------------------------------------

#if HAVE_EVDEV
Opened open_joystick(const std::string &path, const DeviceChoice &choice) {
  return open_evdev(path, choice.dead_man == DeadMan::button);
}

std::vector<FoundDevice> list_joysticks() {
  std::vector<FoundDevice> devices;
  for (const EvdevUnit &unit : list_evdev().with_force)
    devices.push_back({unit.name, "evdev:" + unit.path, ""});
  return devices;
}

std::string find_joystick(const std::string &identity) {
  return find_evdev(identity);
}
#else
Opened open_joystick(const std::string & /*path*/, const DeviceChoice & /*choice*/) {
  throw spidar::Error(spidar::Cause::argument, messages::kNoJoysticksBuilt);
}

constexpr auto list_joysticks = nullptr;
constexpr auto find_joystick = nullptr;
#endif

constexpr std::array kDrivers = {
    Driver{"none", false, nullptr, open_none, nullptr},
    Driver{"sim", false, nullptr, open_simulated, nullptr},
    Driver{"usb", true, list_spidars, open_spidar, find_spidar},
    Driver{"evdev", true, list_joysticks, open_joystick, find_joystick},
};

} // namespace

std::span<const Driver> drivers() noexcept {
  return kDrivers;
}

} // namespace haptic
