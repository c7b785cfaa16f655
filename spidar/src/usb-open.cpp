// Finds the controllers on USB and opens the wanted one.
#include "spidar/device.hpp"
#include "spidar/error.hpp"
#include "usb-controllers.hpp"
#include "usb-protocol.hpp"

#include <charconv>
#include <optional>
#include <vector>

namespace spidar {

namespace {

struct Found {
  UsbDevice device;
  std::uint16_t product;
};

UsbContext make_context() {
  libusb_context *context = nullptr;
  if (const int error = libusb_init(&context); error != 0)
    throw Error(Cause::io, std::string("USB cannot be used (") + libusb_strerror(error) +
                               "). Is /dev/bus/usb there and readable?");
  return UsbContext(context, LibusbDeleter());
}

std::vector<Found> find_controllers(libusb_context *context) {
  libusb_device **list = nullptr;
  const ssize_t count = libusb_get_device_list(context, &list);
  std::vector<Found> found;
  for (ssize_t i = 0; i < count; ++i) {
    UsbDevice device(list[i]); // takes over the list's reference
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(device.get(), &descriptor) == 0 &&
        descriptor.idVendor == kVendor)
      found.push_back({std::move(device), descriptor.idProduct});
  }
  libusb_free_device_list(list, 0);
  return found;
}

bool understood(const Found &found) {
  return found.product == kSimpleProduct || found.product == kSh4Product;
}

/// Any switch for an empty id.
std::optional<int> parse_switch(const std::string &id) {
  if (id.empty())
    return std::nullopt;
  int number = -1;
  const char *last = id.data() + id.size();
  if (const auto [end, error] = std::from_chars(id.data(), last, number);
      error != std::errc() || end != last || number < 0 || number > 15)
    throw Error(Cause::argument, "'" + id +
                                     "' is no position of a rotary switch. Give a number from 0 to "
                                     "15 (A on the switch is 10, F is 15).");
  return number;
}

} // namespace

std::unique_ptr<Controller> open_usb(const std::string &id) {
  const std::optional<int> wanted = parse_switch(id);
  const UsbContext context = make_context();
  std::string seen;
  std::optional<Error> refused; // the first reason why a controller could not be had
  for (const Found &found : find_controllers(context.get())) {
    if (!understood(found)) {
      if (found.product == kH8Product)
        seen += " There is a USB 1 controller (0cec:0201), which cannot be driven.";
      continue;
    }
    try {
      auto link = std::make_unique<UsbLink>(context, found.device.get());
      auto controller = make_usb_controller(found.product, std::move(link));
      if (wanted && controller->rotary_switch() != *wanted) {
        seen += " Found: " + controller->description() + ".";
        continue;
      }
      if (!controller->reset())
        throw Error(Cause::io, "The " + controller->description() +
                                   " does not take commands. Switch it off and on, and plug it in "
                                   "again.");
      return controller;
    } catch (const Error &error) {
      if (!refused)
        refused = error;
    }
  }
  if (refused)
    throw *refused;
  const std::string which = wanted ? " with its rotary switch at " + std::to_string(*wanted) : "";
  throw Error(Cause::not_found, "No SPIDAR-G" + which +
                                    " found on USB. Plug it in and switch it on; 'lsusb' should "
                                    "list 0cec:0203 or 0cec:0205." +
                                    seen);
}

bool usb_present() noexcept {
  try {
    const UsbContext context = make_context();
    for (const Found &found : find_controllers(context.get()))
      if (understood(found))
        return true;
  } catch (...) {
    // Where USB cannot be used there is no controller either.
  }
  return false;
}

} // namespace spidar
