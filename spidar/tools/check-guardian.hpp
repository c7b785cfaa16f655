// SPDX-License-Identifier: LGPL-2.1-or-later
// The guardian of a program that is killed: another process drives the device.
#pragma once

#include "promises.hpp"

#include <optional>
#include <sys/types.h>
#include <vector>

namespace spidar_check {

/// Makes guardians children of this process once their program has ended.
void adopt_guardians();
/// Living children of this process.
std::vector<pid_t> children();
/// Sends a signal to the guardian of the open unit, the only child. False if there is none.
bool signal_guardian(int number);

/// How a process ended.
struct End {
  Clock::time_point time;
  bool well; ///< by itself, with status 0
};
/// Nothing if it has not ended within `patience`.
std::optional<End> await_end(pid_t child, std::chrono::milliseconds patience);

/// The device as another process drives it.
struct OtherProgram {
  /// Drives under a force, and calls `pulls` once it does; until it is killed.
  std::function<void(const std::function<void()> &pulls)> drive;
  /// Opens the device and closes it. Throws spidar::Error while another process holds it.
  std::function<void()> open;
  Clock::duration mean_exchange{};
  std::chrono::milliseconds patience{5000}; ///< with its guardian
  std::chrono::milliseconds felt{2000};     ///< a person notices the pull
};

/// Kills that program's process group. No device may be open. `ask` may be empty.
void check_kill(const OtherProgram &program, const Ask &ask, const Report &report);

} // namespace spidar_check
