// SPDX-License-Identifier: LGPL-2.1-or-later
// One opened USB device: claimed interface, and asynchronous bulk transfers that end in time.
//
// The transfers and their buffers are made when the device is opened, so that an exchange allocates
// and locks nothing here. libusb itself takes 64 bytes from the heap for each transfer submitted,
// and its own mutexes, for which nobody contends: the context belongs to this link alone and one
// thread at a time uses it. Waiting is in whole milliseconds, so a deadline may be missed by one.
#pragma once

#include "guard/file-descriptor.hpp"

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

/// As make_usb_context(), but nobody tells it of devices that come and go: libusb's thread for that
/// takes a mutex of each context, which the real-time thread needs for each transfer. Before libusb
/// 1.0.27 that cannot be asked for one context alone; a change on the bus may then delay a tick
/// until that thread of normal priority has linked one message.
UsbContext make_usb_context_of_one_device();

/// Where a device is plugged in.
struct UsbPlace {
  int bus = 0;
  int address = 0;
  std::string port; ///< "1-2.3", as in the kernel's messages

  std::string node() const; ///< "/dev/bus/usb/001/005"
  std::string text() const; ///< "bus 1 device 5", for people
};

class UsbLink {
public:
  using Deadline = std::chrono::steady_clock::time_point;
  using Bytes = std::span<const std::uint8_t>;
  static constexpr int kLargestPacket = 512;

  /// Opens and claims. Throws Error (permission with the udev line, busy with the holder,
  /// not_found, io).
  explicit UsbLink(UsbPlace place);
  ~UsbLink();
  UsbLink(const UsbLink &) = delete;
  UsbLink &operator=(const UsbLink &) = delete;

  /// A packet of the host, and how many replies the controller gives to it. Empty: none is sent.
  struct Request {
    Bytes bytes;
    int replies = 0;
  };

  /// Sends `first` and `second`, and receives `reply`, which may be empty, too. True when both went
  /// out and, before the deadline, every reply that was owed came in, the last of them with exactly
  /// as many bytes as `reply`. An endpoint that stalled is ready again afterwards. Real-time safe
  /// but for what is said above.
  ///
  /// An OUT endpoint that takes nothing until the deadline is blocked: the packets are cancelled,
  /// and the rest packet waits in their place until the endpoint takes it.
  bool exchange(Request first, Request second, std::span<std::uint8_t> reply,
                Deadline deadline) noexcept;

  /// Throws away replies to requests of a program before us, or of a failed attempt to open.
  void drain() noexcept;

  /// The packet that puts the motors at rest, at most kLargestPacket bytes.
  void set_rest(Request packet) noexcept;

  /// Whether the rest packet went out after a blocked endpoint or lost replies, since the call
  /// before.
  bool rested() noexcept { return std::exchange(rested_, false); }

  /// Whether `first` of the last exchange went out.
  bool first_went_out() const noexcept { return first_went_out_; }

  /// Another program with this device open has sent packets that get this many replies, less those
  /// that it has read itself.
  void expect_replies(int replies) noexcept { owed_ += replies; }

  /// Whether that program may be sending, so that a reply to it may come before expect_replies().
  void set_shared(bool shared) noexcept { shared_ = shared; }

  /// Another program with this device open keeps the claim when this link ends.
  void leave_claim() noexcept { claimed_ = false; }

  /// The device has been unplugged: nothing will ever go through again.
  bool gone() const noexcept { return gone_; }

  /// Of usbfs; the claim belongs to whoever has a duplicate of it.
  int file_descriptor() const noexcept { return file_.get(); }

  const UsbPlace &place() const noexcept { return place_; }

private:
  struct Slot {
    std::unique_ptr<libusb_transfer, LibusbDeleter> transfer;
    alignas(64) std::array<unsigned char, kLargestPacket> buffer{};
    int replies = 0; ///< to this packet
    bool flying = false;
  };

  void open_handle();
  int find_endpoints();
  void prepare(Slot &slot, unsigned char endpoint, libusb_transfer_cb_fn landed, void *data);
  bool submit(Slot &slot, int size) noexcept;
  bool submit(Slot &slot, const Request &request) noexcept;
  void listen() noexcept;
  void on_reply() noexcept;
  void add_reply(int length) noexcept;
  template <class Done>
  bool wait(Deadline deadline, Done done) noexcept;
  bool out_flying() const noexcept { return first_.flying || second_.flying; }
  void collect() noexcept;
  void start_resting() noexcept;
  void finish_resting(Deadline deadline) noexcept;
  void listen_only(Deadline deadline) noexcept;
  void cancel(Slot &slot) noexcept;
  bool went_out(Slot &slot, const Request &request) noexcept;
  void clear_stalled_in() noexcept;

  UsbPlace place_;
  UsbContext context_;
  FileDescriptor file_; ///< outlives the handle, which does not close it
  std::unique_ptr<libusb_device_handle, LibusbDeleter> handle_;
  int interface_ = 0;
  bool claimed_ = false;
  bool gone_ = false;

  Slot first_;
  Slot second_;
  Slot rest_; ///< sent when an endpoint was blocked or replies are missing
  Request rest_request_;
  std::array<std::uint8_t, kLargestPacket> rest_packet_{};
  bool resting_ = false; ///< rest_ must go out before anything else
  bool rested_ = false;
  bool first_went_out_ = false;

  // Always listening: a reply that nobody asked for must not wait to be taken for the next one.
  Slot reply_;
  bool in_stalled_ = false;
  bool closing_ = false;
  std::array<std::uint8_t, kLargestPacket> newest_{};
  int newest_length_ = -1;      ///< -1: a reply that is none
  std::uint64_t replies_ = 0;   ///< received since the device was opened
  int owed_ = 0;                ///< replies asked for and not received; negative: unasked ones
  bool shared_ = false;         ///< unasked ones may be to another program's packets
  int out_of_step_ = 0;         ///< exchanges in a row that ended with a reply owed
  Deadline last_on_the_wire_{}; ///< a packet or a reply
};

} // namespace spidar
