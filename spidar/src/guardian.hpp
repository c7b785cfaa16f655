// SPDX-License-Identifier: LGPL-2.1-or-later
// The process that puts the motors at rest if this process dies or hangs.
//
// It holds a duplicate of the device's file descriptor, so that the claim outlives this process,
// and a socket: a message there shows that this process lives, its end that it has died.
#pragma once

#include "usb-link.hpp"

namespace spidar {

class Guardian {
public:
  using Clock = std::chrono::steady_clock;

  /// `device` is a descriptor of usbfs, or a datagram socket that stands for one; `packet`, written
  /// to `endpoint`, puts the motors at rest. Returns once the guardian watches. Throws Error (io).
  Guardian(int device, unsigned char endpoint, std::span<const std::uint8_t> packet);
  /// Lets the guardian put the motors at rest and end, and waits for it: it shares the claim.
  ~Guardian();
  Guardian(const Guardian &) = delete;
  Guardian &operator=(const Guardian &) = delete;

  /// Sends a sign of life; call it before every exchange. With `force`, the guardian puts the
  /// motors at rest after kGuardianPatience without one. False if the guardian is dead. Real-time
  /// safe: two system calls at most.
  bool watch(bool force, Clock::time_point now) noexcept;

  /// Whether the guardian has put the motors at rest since the call before. Call watch() first.
  bool let_go() noexcept { return std::exchange(let_go_, false); }

  int process() const noexcept { return process_; }

private:
  void start(int device, int control);
  void await_ready();

  FileDescriptor socket_;
  Clock::time_point last_word_{};
  int process_ = 0;
  bool force_ = false;
  bool let_go_ = false;
  bool dead_ = false;
};

/// Path of the program: $SPIDAR_GUARDIAN, or where it was installed.
std::string guardian_path();

} // namespace spidar
