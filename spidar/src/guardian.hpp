// SPDX-License-Identifier: LGPL-2.1-or-later
// The helper process that lets go of the motors when this one dies or hangs.
//
// It has a duplicate of the device's file descriptor, so that the claim outlives this process, and
// one socket: what comes in says that this process lives, its end says that it does not.
#pragma once

#include "usb-link.hpp"

namespace spidar {

class Guardian {
public:
  using Clock = std::chrono::steady_clock;

  /// `device` is a descriptor of usbfs, or a datagram socket that stands for one; `packet`, written
  /// to `endpoint`, puts the motors at rest. Returns once the guardian watches. Throws Error (io).
  Guardian(int device, unsigned char endpoint, std::span<const std::uint8_t> packet);
  /// It puts the motors at rest a last time and ends; waited for, since it shares the claim.
  ~Guardian();
  Guardian(const Guardian &) = delete;
  Guardian &operator=(const Guardian &) = delete;

  /// Says that this process lives, to be called before every exchange. While there is `force` it
  /// must not be silent for kGuardianPatience. False when the guardian is dead. Real-time safe: two
  /// system calls at most.
  bool watch(bool force, Clock::time_point now) noexcept;

  /// Whether it has put the motors at rest since this was last asked, watch() having been called.
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

/// Where the helper executable is: $SPIDAR_GUARDIAN, or where it was installed.
std::string guardian_path();

} // namespace spidar
