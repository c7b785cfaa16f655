// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usb-link.hpp"

#include "fail.hpp"
#include "usb-holder.hpp"
#include "usb-protocol.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace spidar {

namespace {

constexpr int kMostStaleReplies = 16;
constexpr auto kStaleReplyTime = std::chrono::milliseconds(1); // what waits is there at once
constexpr auto kCancelTime = std::chrono::milliseconds(2);     // the kernel does it at once
constexpr auto kCloseTime = std::chrono::milliseconds(50);

[[noreturn]] void refuse(const UsbPlace &place, int error) {
  const std::string where = place.text();
  switch (error) {
  case LIBUSB_ERROR_ACCESS:
    fail(Cause::permission, messages::kUsbForbidden, where.c_str());
  case LIBUSB_ERROR_BUSY:
    fail(Cause::busy, messages::kUsbBusy, where.c_str(), holder_of(place.node()).c_str());
  case LIBUSB_ERROR_NO_DEVICE:
    fail(Cause::not_found, messages::kUsbUnplugged, where.c_str());
  default:
    fail(Cause::io, messages::kUsbNotOpened, where.c_str(), libusb_strerror(error));
  }
}

int libusb_error_of(int error_number) {
  switch (error_number) {
  case EACCES:
  case EPERM:
    return LIBUSB_ERROR_ACCESS;
  case ENOENT:
  case ENODEV:
  case ENXIO:
    return LIBUSB_ERROR_NO_DEVICE;
  default:
    return LIBUSB_ERROR_IO;
  }
}

} // namespace

UsbContext make_usb_context() {
  libusb_context *context = nullptr;
  if (const int error = libusb_init(&context); error != 0)
    fail(Cause::io, messages::kUsbUnusable, libusb_strerror(error));
  return UsbContext(context);
}

std::string UsbPlace::node() const {
  std::array<char, 64> path;
  std::snprintf(path.data(), path.size(), "/dev/bus/usb/%03d/%03d", bus, address);
  return path.data();
}

std::string UsbPlace::text() const {
  return "bus " + std::to_string(bus) + " device " + std::to_string(address);
}

void FileDescriptor::reset(int value) noexcept {
  if (value_ >= 0)
    close(value_);
  value_ = value;
}

UsbLink::UsbLink(UsbPlace place) : place_(std::move(place)), context_(make_usb_context()) {
  open_handle();
  const int alternate = find_endpoints();
  libusb_set_auto_detach_kernel_driver(handle_.get(), 1); // no harm where there is no such thing
  if (const int error = libusb_claim_interface(handle_.get(), interface_); error != 0)
    refuse(place_, error);
  claimed_ = true;
  if (alternate != 0)
    if (const int error = libusb_set_interface_alt_setting(handle_.get(), interface_, alternate);
        error != 0)
      refuse(place_, error);
  prepare(first_, kEndpointOut);
  prepare(second_, kEndpointOut);
  prepare(reply_, kEndpointIn);
}

UsbLink::~UsbLink() {
  cancel();
  if (!wait(std::chrono::steady_clock::now() + kCloseTime)) {
    // libusb still uses them: leak them rather than free them.
    for (Slot *slot : {&first_, &second_, &reply_})
      if (slot->flying)
        static_cast<void>(slot->transfer.release());
  }
  if (claimed_)
    libusb_release_interface(handle_.get(), interface_);
}

// libusb_open() does not give the descriptor, of which the guardian needs a duplicate.
void UsbLink::open_handle() {
  file_.reset(open(place_.node().c_str(), O_RDWR | O_CLOEXEC));
  if (file_.get() < 0)
    refuse(place_, libusb_error_of(errno));
  libusb_device_handle *handle = nullptr;
  if (const int error = libusb_wrap_sys_device(context_.get(), file_.get(), &handle); error != 0)
    refuse(place_, error);
  handle_.reset(handle);
}

/// Finds the endpoints by their addresses, as others may exist. Returns the alternate setting.
int UsbLink::find_endpoints() {
  libusb_config_descriptor *raw = nullptr;
  if (const int error = libusb_get_active_config_descriptor(libusb_get_device(handle_.get()), &raw);
      error != 0)
    refuse(place_, error);
  const std::unique_ptr<libusb_config_descriptor, LibusbDeleter> configuration(raw);
  const auto has = [](const libusb_interface_descriptor &setting, unsigned char address) {
    return std::any_of(setting.endpoint, setting.endpoint + setting.bNumEndpoints,
                       [address](const libusb_endpoint_descriptor &endpoint) {
                         return endpoint.bEndpointAddress == address &&
                                (endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) ==
                                    LIBUSB_TRANSFER_TYPE_BULK;
                       });
  };
  for (int i = 0; i < configuration->bNumInterfaces; ++i) {
    const libusb_interface &interface = configuration->interface[i];
    for (int k = 0; k < interface.num_altsetting; ++k) {
      const libusb_interface_descriptor &setting = interface.altsetting[k];
      if (has(setting, kEndpointOut) && has(setting, kEndpointIn)) {
        interface_ = setting.bInterfaceNumber;
        return setting.bAlternateSetting;
      }
    }
  }
  fail(Cause::io, messages::kUsbEndpoints, place_.text().c_str());
}

void UsbLink::prepare(Slot &slot, unsigned char endpoint) {
  slot.transfer.reset(libusb_alloc_transfer(0));
  if (!slot.transfer)
    fail(Cause::io, messages::kUsbMemory);
  const auto landed = [](libusb_transfer *transfer) {
    static_cast<Slot *>(transfer->user_data)->flying = false;
  };
  libusb_fill_bulk_transfer(slot.transfer.get(), handle_.get(), endpoint, slot.buffer.data(), 0,
                            landed, &slot, 0); // who waits watches the time
}

bool UsbLink::submit(Slot &slot, int size) noexcept {
  slot.transfer->length = size;
  slot.flying = true; // before it can land
  const int error = libusb_submit_transfer(slot.transfer.get());
  if (error == 0)
    return true;
  slot.flying = false;
  gone_ = gone_ || error == LIBUSB_ERROR_NO_DEVICE;
  return false;
}

bool UsbLink::submit(Slot &slot, Bytes bytes) noexcept {
  std::copy(bytes.begin(), bytes.end(), slot.buffer.begin());
  return bytes.empty() || submit(slot, static_cast<int>(bytes.size()));
}

bool UsbLink::flying() const noexcept {
  return first_.flying || second_.flying || reply_.flying;
}

bool UsbLink::wait(Deadline deadline) noexcept {
  using std::chrono::ceil, std::chrono::microseconds;
  while (flying()) {
    const auto left = ceil<microseconds>(deadline - std::chrono::steady_clock::now()).count();
    if (left <= 0)
      return false;
    timeval time{.tv_sec = left / 1'000'000, .tv_usec = left % 1'000'000};
    if (const int error = libusb_handle_events_timeout_completed(context_.get(), &time, nullptr);
        error != 0 && error != LIBUSB_ERROR_INTERRUPTED)
      return false;
  }
  return true;
}

void UsbLink::cancel() noexcept {
  for (Slot *slot : {&first_, &second_, &reply_})
    if (slot->flying)
      libusb_cancel_transfer(slot->transfer.get());
}

bool UsbLink::succeeded(Slot &slot, std::size_t size) noexcept {
  switch (slot.transfer->status) {
  case LIBUSB_TRANSFER_COMPLETED:
    return static_cast<std::size_t>(slot.transfer->actual_length) == size;
  case LIBUSB_TRANSFER_STALL:
    libusb_clear_halt(handle_.get(), slot.transfer->endpoint);
    return false;
  case LIBUSB_TRANSFER_NO_DEVICE:
    gone_ = true;
    return false;
  default:
    return false;
  }
}

bool UsbLink::exchange(Bytes first, Bytes second, std::span<std::uint8_t> reply,
                       Deadline deadline) noexcept {
  reply_owed_ = !reply.empty();
  // A transfer that could not be cancelled in time blocks its slot until it lands.
  if (gone_ || (flying() && !wait(deadline)))
    return false;
  // With room for a whole packet, a reply that is too long is seen as such and not as an overflow.
  const bool under_way = submit(first_, first) && submit(second_, second) &&
                         (reply.empty() || submit(reply_, kLargestPacket));
  if (!under_way || !wait(deadline)) {
    cancel();
    wait(std::chrono::steady_clock::now() + kCancelTime);
    if (!under_way)
      return false;
  }
  if (flying())
    return false;
  reply_owed_ = !reply.empty() && reply_.transfer->status == LIBUSB_TRANSFER_CANCELLED;
  // Each is looked at, so that whatever stalled is made ready.
  const bool first_sent = first.empty() || succeeded(first_, first.size());
  const bool second_sent = second.empty() || succeeded(second_, second.size());
  const bool answered = reply.empty() || succeeded(reply_, reply.size());
  if (!first_sent || !second_sent || !answered)
    return false;
  std::copy_n(reply_.buffer.begin(), reply.size(), reply.begin());
  return true;
}

void UsbLink::drain() noexcept {
  for (int i = 0; i < kMostStaleReplies && !gone_ && !flying(); ++i) {
    if (!submit(reply_, kLargestPacket))
      return;
    const bool came = wait(std::chrono::steady_clock::now() + kStaleReplyTime);
    if (!came) {
      cancel();
      wait(std::chrono::steady_clock::now() + kCancelTime);
    }
    if (flying() || (!succeeded(reply_, 0) && reply_.transfer->actual_length == 0))
      return;
  }
}

} // namespace spidar
