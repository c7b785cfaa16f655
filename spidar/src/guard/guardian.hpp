// SPDX-License-Identifier: LGPL-2.1-or-later
// The process that puts the motors at rest if this process dies or hangs.
//
// It holds a duplicate of the device's file descriptor, so that the claim outlives this process,
// and a socket: a word there shows that this process lives, its end that it has died. The guardian
// answers each, so that one that was stopped is noticed too. guardian-protocol.hpp has the
// messages.
#pragma once

#include "guard/file-descriptor.hpp"
#include "guard/guardian-protocol.hpp"

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

namespace spidar {

/// Path of the helper program: $SPIDAR_GUARDIAN, or where it was installed.
std::string guardian_path();

/// Whether the user's service is tried first: a program that says which helper it wants gets that.
bool guardian_service_wanted();

class Guardian {
public:
  using Clock = std::chrono::steady_clock;

  static constexpr auto kPatience = std::chrono::milliseconds(10);

  /// `device` is a descriptor of usbfs, or a datagram socket that stands for one; `packet`, written
  /// to `endpoint`, puts the motors at rest. If the controller replies to it, the replies come at
  /// `reply_endpoint`. Returns once the guardian watches: the user's service if there is one, else
  /// a helper program. Throws Error (io).
  Guardian(int device, unsigned char endpoint, std::span<const std::uint8_t> packet,
           std::chrono::milliseconds patience = kPatience,
           bool use_service = guardian_service_wanted(), unsigned char reply_endpoint = 0);
  ~Guardian() { end(); }
  Guardian(const Guardian &) = delete;
  Guardian &operator=(const Guardian &) = delete;

  /// Lets the guardian put the motors at rest and end, and waits for it for 0.2 s. False: the
  /// device takes nothing, and the guardian still tries. It shares the claim, which must not be
  /// released under it. Call nothing else afterwards.
  bool end() noexcept;

  enum class Watch {
    kept,   ///< it watches
    silent, ///< it has not answered for some milliseconds or reads nothing, and may again
    dead
  };

  /// Reads what the guardian has sent, and sends it a sign of life if it is time for one; call it
  /// before every exchange. `force`: the motors have, or may have, more than minimum tension. Then
  /// the guardian puts them at rest after its patience without a sign. Real-time safe: only
  /// system calls that do not wait.
  Watch watch(bool force, Clock::time_point now) noexcept;

  /// Whether the guardian has put the motors at rest since the call before. Call watch() first.
  bool let_go() noexcept { return std::exchange(let_go_, false); }

  /// Rest packets of the guardian that were delivered since the call before.
  int delivered() noexcept { return static_cast<int>(std::exchange(delivered_, 0)); }

  /// Replies of the controller that the guardian has read since the call before.
  int replies_read() noexcept { return static_cast<int>(std::exchange(replies_, 0)); }

  /// Whether the guardian intervenes: it writes to the device, or tries to, until it has heard that
  /// this process knows.
  bool intervenes() const noexcept { return intervenes_; }

  int process() const noexcept { return process_; }

  /// If the user has a service that does not watch, what to do; else empty.
  const std::string &remark() const noexcept { return remark_; }

private:
  bool connect_to_service(int device, std::span<const std::uint8_t> order);
  bool send_order(int device, std::span<const std::uint8_t> order) const;
  bool service_watches();
  void start_helper(int device, int control);
  bool await_ready();
  void read_notices() noexcept;

  FileDescriptor socket_;
  Clock::time_point last_word_{};
  Clock::time_point first_unanswered_{};
  int unanswered_ = 0; ///< words
  std::uint32_t delivered_before_ = 0;
  std::uint32_t delivered_ = 0;
  std::uint32_t replies_before_ = 0;
  std::uint32_t replies_ = 0;
  int process_ = 0;
  std::string remark_;
  std::uint8_t intervention_ = 0; ///< the newest that it has told
  GuardianWord told_;             ///< the newest word
  bool unsent_ = false;           ///< the word after that did not fit into the socket
  bool let_go_ = false;
  bool intervenes_ = false;
  bool dead_ = false;
};

} // namespace spidar
