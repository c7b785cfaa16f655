// SPDX-License-Identifier: LGPL-2.1-or-later
// What the guardian does: it listens to the process, and writes to the device that it was given.
// guardian.pml is the model of watch(). It uses the kernel only and allocates nothing.
#pragma once

#include "guard/guardian-protocol.hpp"

struct msghdr;

namespace spidar {

class GuardedMotors {
public:
  /// `control` is the socket. `device` is a descriptor of usbfs, or a datagram socket that stands
  /// for one; -1: it comes with the order.
  GuardedMotors(int control, int device) noexcept : control_(control), device_(device) {}

  /// Receives the order and, from a process that did not start us, the device. False without one;
  /// refuses an order of another version.
  bool receive_order() noexcept;

  /// Says that it watches, watches until the process ends, and leaves the motors at rest.
  void guard() noexcept;

private:
  enum class Written {
    delivered,
    refused, ///< the device takes nothing now
    gone     ///< there is no device any more
  };

  void accept_device(msghdr &message) noexcept;
  bool notify(std::uint8_t kind, std::uint32_t value) const noexcept;
  void answer() const noexcept { notify(intervenes_ ? kResting : kHere, delivered_); }
  void watch() noexcept;
  void intervene() noexcept;
  bool hear() noexcept;
  void end_at_rest() noexcept;
  Written rest() noexcept;
  bool write() noexcept;
  void read_replies() noexcept;

  int control_;
  int device_;
  unsigned char packet_[kLargestGuardedPacket]{};
  unsigned size_ = 0;
  unsigned endpoint_ = 0;
  unsigned reply_endpoint_ = 0;
  int patience_ = kGuardianPatience; ///< ms of silence under a force
  int silence_ = -1;                 ///< ms until it writes; -1: never
  std::uint32_t delivered_ = 0;      ///< rest packets
  std::uint32_t replies_ = 0;        ///< read
  std::uint8_t intervention_ = 0;
  bool intervenes_ = false;
  bool force_ = false; ///< of the newest word
  bool is_socket_ = false;
};

} // namespace spidar
