// SPDX-License-Identifier: LGPL-2.1-or-later
// Finds the controllers on USB and opens the wanted one.
#include "fail.hpp"
#include "spidar/usb.hpp"
#include "usb/usb-controllers.hpp"
#include "usb/usb-protocol.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace spidar {

namespace {

struct Kind {
  std::uint16_t vendor;
  std::uint16_t product;
  UsbModel model;
};

struct Found {
  UsbPlace place;
  UsbModel model;
};

struct Findings {
  std::vector<Found> units;
  std::optional<UsbPlace> old_controller; ///< one whose protocol is not known
};

std::vector<Kind> known_kinds() {
  std::vector<Kind> kinds = {{kVendor, kSimpleProduct, UsbModel::simple},
                             {kVendor, kSh4Product, UsbModel::sh4}};
  if (const char *value = std::getenv("SPIDAR_USB_ID")) {
    Kind kind{};
    std::array<char, 8> model{};
    int end = 0;
    // Four digits always fit.
    // NOLINTNEXTLINE(bugprone-unchecked-string-to-number-conversion)
    const bool parsed = std::sscanf(value, "%4hx:%4hx=%7s%n", &kind.vendor, &kind.product,
                                    model.data(), &end) == 3 &&
                        static_cast<std::size_t>(end) == std::strlen(value);
    const bool simple = std::strcmp(model.data(), "simple") == 0;
    if (!parsed || (!simple && std::strcmp(model.data(), "sh4") != 0))
      fail(Cause::argument, messages::kUsbId, value);
    kind.model = simple ? UsbModel::simple : UsbModel::sh4;
    kinds.insert(kinds.begin(), kind); // it may say what a known one is
  }
  return kinds;
}

UsbPlace place_of(libusb_device *device) {
  UsbPlace place{libusb_get_bus_number(device), libusb_get_device_address(device), ""};
  std::array<std::uint8_t, 8> ports{};
  const int depth = libusb_get_port_numbers(device, ports.data(), ports.size());
  for (int i = 0; i < depth; ++i)
    place.port += (i == 0 ? std::to_string(place.bus) + "-" : ".") +
                  std::to_string(ports[static_cast<std::size_t>(i)]);
  return place;
}

Findings find_controllers() {
  const std::vector<Kind> kinds = known_kinds();
  const UsbContext context = make_usb_context();
  libusb_device **list = nullptr;
  const ssize_t count = libusb_get_device_list(context.get(), &list);
  Findings findings;
  for (ssize_t i = 0; i < count; ++i) {
    const UsbDevice device(list[i]); // takes over the list's reference
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(device.get(), &descriptor) != 0)
      continue;
    const auto kind = std::ranges::find_if(kinds, [&](const Kind &one) {
      return descriptor.idVendor == one.vendor && descriptor.idProduct == one.product;
    });
    if (kind != kinds.end())
      findings.units.push_back({place_of(device.get()), kind->model});
    if (descriptor.idVendor == kVendor && descriptor.idProduct == kH8Product)
      findings.old_controller = place_of(device.get());
  }
  libusb_free_device_list(list, 0);
  return findings;
}

std::unique_ptr<UsbController> open_unit(const Found &found) {
  return make_usb_controller(found.model, std::make_unique<UsbLink>(found.place));
}

/// Any switch for an empty id.
std::optional<int> parse_switch(const std::string &id) {
  if (id.empty())
    return std::nullopt;
  int number = -1;
  const char *last = id.data() + id.size();
  if (const auto [end, error] = std::from_chars(id.data(), last, number);
      error != std::errc() || end != last || number < 0 || number > 15)
    fail(Cause::argument, messages::kUsbSwitch, id.c_str());
  return number;
}

/// Controllers found instead of the wanted one.
struct Others {
  std::string seen;
  std::optional<Error> refused; ///< the first reason why one could not be had
};

std::unique_ptr<UsbController> first_of(const Findings &findings, Others &others) {
  for (const Found &found : findings.units) {
    try {
      return open_unit(found);
    } catch (const Error &error) {
      if (!others.refused)
        others.refused = error;
    }
  }
  return nullptr;
}

/// Opens all, to refuse two with the same switch.
std::unique_ptr<UsbController> only_one_at(int wanted, const Findings &findings, Others &others) {
  std::unique_ptr<UsbController> result;
  for (const Found &found : findings.units) {
    try {
      auto controller = open_unit(found);
      if (controller->rotary_switch() != wanted) {
        others.seen += " Found: " + controller->description() + ".";
      } else if (result) {
        fail(Cause::argument, messages::kUsbSameSwitch, wanted, result->description().c_str(),
             controller->description().c_str());
      } else {
        result = std::move(controller);
      }
    } catch (const Error &error) {
      if (error.cause() == Cause::argument)
        throw;
      if (!others.refused)
        others.refused = error;
    }
  }
  return result;
}

} // namespace

std::vector<UsbUnit> list_usb() {
  std::vector<UsbUnit> units;
  const Findings findings = find_controllers();
  for (const Found &found : findings.units) {
    UsbUnit unit{name_of(found.model), found.place.bus, found.place.address,
                 found.place.port,     std::nullopt,    std::nullopt};
    try {
      unit.switch_at = open_unit(found)->rotary_switch();
    } catch (const Error &error) {
      unit.problem = error;
    }
    units.push_back(std::move(unit));
  }
  if (const auto &old = findings.old_controller)
    units.push_back({"USB 1", old->bus, old->address, old->port, std::nullopt,
                     Error(Cause::io, messages::kUsbOld)});
  return units;
}

std::unique_ptr<Controller> open_usb(const std::string &id) {
  const std::optional<int> wanted = parse_switch(id);
  const Findings findings = find_controllers();
  Others others;
  auto controller = wanted ? only_one_at(*wanted, findings, others) : first_of(findings, others);
  if (controller) {
    if (!controller->reset())
      fail(Cause::io, messages::kUsbRefuses, controller->description().c_str());
    return controller;
  }
  if (others.refused)
    throw *others.refused;
  if (findings.old_controller)
    others.seen += " There is a USB 1 controller (0cec:0201), which cannot be driven.";
  const std::string which = wanted ? " with its rotary switch at " + std::to_string(*wanted) : "";
  fail(Cause::not_found, messages::kNotOnUsb, which.c_str(), others.seen.c_str());
}

bool usb_present() {
  try {
    return !find_controllers().units.empty();
  } catch (const Error &error) {
    if (error.cause() == Cause::argument)
      throw;
    return false; // where USB cannot be used there is no controller either
  }
}

} // namespace spidar
