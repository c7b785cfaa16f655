#include "usb-link.hpp"

#include "spidar/error.hpp"
#include "usb-protocol.hpp"

#include <algorithm>
#include <array>

namespace spidar {

namespace {

constexpr int kInterface = 0;
constexpr int kLargestPacket = 512;
constexpr int kMostStaleReplies = 16;
constexpr auto kStaleReplyTime = std::chrono::milliseconds(1); // what waits is there at once

[[noreturn]] void refuse(const std::string &place, int error) {
  const std::string device = "The SPIDAR-G on USB " + place;
  switch (error) {
  case LIBUSB_ERROR_ACCESS:
    throw Error(Cause::permission,
                device + " may not be opened by this user. Put the line\n"
                         "  SUBSYSTEM==\"usb\", ATTR{idVendor}==\"0cec\", "
                         "ATTR{idProduct}==\"0201|0203|0205\", TAG+=\"uaccess\"\n"
                         "into /etc/udev/rules.d/70-spidar.rules, then run 'sudo udevadm control "
                         "--reload' and plug the device in again.");
  case LIBUSB_ERROR_BUSY:
    throw Error(Cause::busy, device + " is in use by another program. Close that program first.");
  case LIBUSB_ERROR_NO_DEVICE:
    throw Error(Cause::not_found, device + " has been unplugged. Plug it in and try again.");
  default:
    throw Error(Cause::io, device + " cannot be opened (" + libusb_strerror(error) +
                               "). Unplug it, switch it off and on, and plug it in again.");
  }
}

} // namespace

UsbLink::UsbLink(UsbContext context, libusb_device *device)
    : context_(std::move(context)),
      place_("bus " + std::to_string(libusb_get_bus_number(device)) + " device " +
             std::to_string(libusb_get_device_address(device))) {
  libusb_device_handle *handle = nullptr;
  if (const int error = libusb_open(device, &handle); error != 0)
    refuse(place_, error);
  handle_.reset(handle);
  libusb_set_auto_detach_kernel_driver(handle, 1); // where the system has no such thing: no harm
  if (const int error = libusb_claim_interface(handle, kInterface); error != 0)
    refuse(place_, error);
}

UsbLink::~UsbLink() {
  libusb_release_interface(handle_.get(), kInterface);
}

bool UsbLink::transfer(unsigned char endpoint, unsigned char *bytes, int size, int &transferred,
                       Deadline deadline) noexcept {
  using std::chrono::ceil, std::chrono::milliseconds;
  const auto left = ceil<milliseconds>(deadline - std::chrono::steady_clock::now()).count();
  if (left <= 0) // to libusb 0 means "wait for ever"
    return false;
  const int error = libusb_bulk_transfer(handle_.get(), endpoint, bytes, size, &transferred,
                                         static_cast<unsigned>(left));
  if (error == LIBUSB_ERROR_PIPE)
    libusb_clear_halt(handle_.get(), endpoint);
  return error == 0;
}

bool UsbLink::send(std::span<const std::uint8_t> bytes, Deadline deadline) noexcept {
  int sent = 0;
  const int size = static_cast<int>(bytes.size());
  // libusb takes one kind of pointer for both directions; it does not write through this one.
  auto *data = const_cast<unsigned char *>(bytes.data());
  return transfer(kEndpointOut, data, size, sent, deadline) && sent == size;
}

bool UsbLink::receive(std::span<std::uint8_t> bytes, Deadline deadline) noexcept {
  // With room for a whole packet, a reply that is too long is seen as such and not as an overflow.
  std::array<unsigned char, kLargestPacket> packet;
  int received = 0;
  if (!transfer(kEndpointIn, packet.data(), kLargestPacket, received, deadline) ||
      static_cast<std::size_t>(received) != bytes.size())
    return false;
  std::copy_n(packet.begin(), received, bytes.begin());
  return true;
}

void UsbLink::drain() noexcept {
  std::array<unsigned char, kLargestPacket> packet;
  for (int i = 0; i < kMostStaleReplies; ++i) {
    int received = 0;
    const auto deadline = std::chrono::steady_clock::now() + kStaleReplyTime;
    if (!transfer(kEndpointIn, packet.data(), kLargestPacket, received, deadline))
      return;
  }
}

} // namespace spidar
