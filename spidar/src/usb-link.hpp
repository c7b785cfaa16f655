// One opened USB device: claimed interface and bulk transfers that end in time.
//
// libusb takes memory and locks of its own for each transfer. No way around it leads through
// libusb, so what a tick on USB is promised is its deadline, counted in whole milliseconds.
#pragma once

#include <chrono>
#include <cstdint>
#include <libusb.h>
#include <memory>
#include <span>
#include <string>

namespace spidar {

struct LibusbDeleter {
  void operator()(libusb_context *context) const noexcept { libusb_exit(context); }
  void operator()(libusb_device *device) const noexcept { libusb_unref_device(device); }
  void operator()(libusb_device_handle *handle) const noexcept { libusb_close(handle); }
};
using UsbContext = std::shared_ptr<libusb_context>;
using UsbDevice = std::unique_ptr<libusb_device, LibusbDeleter>;

class UsbLink {
public:
  using Deadline = std::chrono::steady_clock::time_point;

  /// Opens and claims `device`. Throws Error (permission with the udev line, busy, io).
  UsbLink(UsbContext context, libusb_device *device);
  ~UsbLink();
  UsbLink(const UsbLink &) = delete;
  UsbLink &operator=(const UsbLink &) = delete;

  /// True when all bytes went out before the deadline.
  bool send(std::span<const std::uint8_t> bytes, Deadline deadline) noexcept;

  /// True when exactly as many bytes came in before the deadline.
  bool receive(std::span<std::uint8_t> bytes, Deadline deadline) noexcept;

  /// Throws away replies to requests that a program before us, or a failed exchange, left behind.
  void drain() noexcept;

  /// "bus 1 device 5", for people.
  const std::string &place() const noexcept { return place_; }

private:
  bool transfer(unsigned char endpoint, unsigned char *bytes, int size, int &transferred,
                Deadline deadline) noexcept;

  UsbContext context_; ///< outlives the handle
  std::unique_ptr<libusb_device_handle, LibusbDeleter> handle_;
  std::string place_;
};

} // namespace spidar
