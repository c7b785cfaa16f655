// SPDX-License-Identifier: LGPL-2.1-or-later
// One opened USB device: claimed interface, and asynchronous bulk transfers that end in time.
//
// The transfers and their buffers are made when the device is opened, so that an exchange allocates
// and locks nothing here. libusb itself takes 64 bytes from the heap for each transfer submitted,
// and its own mutexes, for which nobody contends: the context belongs to this link alone and one
// thread at a time uses it. Waiting is in whole milliseconds, so a deadline may be missed by one.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <libusb.h>
#include <memory>
#include <span>
#include <string>
#include <utility>

namespace spidar {

struct LibusbDeleter {
  void operator()(libusb_context *context) const noexcept { libusb_exit(context); }
  void operator()(libusb_device *device) const noexcept { libusb_unref_device(device); }
  void operator()(libusb_device_handle *handle) const noexcept { libusb_close(handle); }
  void operator()(libusb_transfer *transfer) const noexcept { libusb_free_transfer(transfer); }
  void operator()(libusb_config_descriptor *configuration) const noexcept {
    libusb_free_config_descriptor(configuration);
  }
};
using UsbContext = std::unique_ptr<libusb_context, LibusbDeleter>;
using UsbDevice = std::unique_ptr<libusb_device, LibusbDeleter>;

/// Throws Error (io).
UsbContext make_usb_context();

/// Where a device is plugged in.
struct UsbPlace {
  int bus = 0;
  int address = 0;
  std::string port; ///< "1-2.3", as in the kernel's messages

  std::string node() const; ///< "/dev/bus/usb/001/005"
  std::string text() const; ///< "bus 1 device 5", for people
};

class FileDescriptor {
public:
  explicit FileDescriptor(int value = -1) noexcept : value_(value) {}
  ~FileDescriptor() { reset(); }
  FileDescriptor(FileDescriptor &&other) noexcept : value_(std::exchange(other.value_, -1)) {}
  FileDescriptor &operator=(FileDescriptor &&other) noexcept {
    reset(std::exchange(other.value_, -1));
    return *this;
  }
  int get() const noexcept { return value_; }
  void reset(int value = -1) noexcept;

private:
  int value_;
};

class UsbLink {
public:
  using Deadline = std::chrono::steady_clock::time_point;
  using Bytes = std::span<const std::uint8_t>;

  /// Opens and claims. Throws Error (permission with the udev line, busy with the holder,
  /// not_found, io).
  explicit UsbLink(UsbPlace place);
  ~UsbLink();
  UsbLink(const UsbLink &) = delete;
  UsbLink &operator=(const UsbLink &) = delete;

  /// Sends `first` and `second`, which may be empty, and receives `reply`, which may be too. True
  /// when all went out and exactly as many bytes came in before the deadline. An endpoint that
  /// stalled is ready again afterwards. Real-time safe but for what is said above.
  bool exchange(Bytes first, Bytes second, std::span<std::uint8_t> reply,
                Deadline deadline) noexcept;

  /// Throws away replies to requests that a program before us, or a failed exchange, left behind.
  void drain() noexcept;

  /// The last exchange ended before its reply had come, which may still be on the way.
  bool reply_owed() const noexcept { return reply_owed_; }

  /// The device has been unplugged: nothing will ever go through again.
  bool gone() const noexcept { return gone_; }

  /// Of usbfs; the claim belongs to whoever has a duplicate of it.
  int file_descriptor() const noexcept { return file_.get(); }

  const UsbPlace &place() const noexcept { return place_; }

private:
  static constexpr int kLargestPacket = 512;

  struct Slot {
    std::unique_ptr<libusb_transfer, LibusbDeleter> transfer;
    alignas(64) std::array<unsigned char, kLargestPacket> buffer{};
    bool flying = false;
  };

  void open_handle();
  int find_endpoints();
  void prepare(Slot &slot, unsigned char endpoint);
  bool submit(Slot &slot, int size) noexcept;
  bool submit(Slot &slot, Bytes bytes) noexcept;
  bool flying() const noexcept;
  bool wait(Deadline deadline) noexcept;
  void cancel() noexcept;
  bool succeeded(Slot &slot, std::size_t size) noexcept;

  UsbPlace place_;
  UsbContext context_;
  FileDescriptor file_; ///< outlives the handle, which does not close it
  std::unique_ptr<libusb_device_handle, LibusbDeleter> handle_;
  int interface_ = 0;
  bool claimed_ = false;
  bool gone_ = false;
  bool reply_owed_ = false;
  Slot first_;
  Slot second_;
  Slot reply_;
};

} // namespace spidar
