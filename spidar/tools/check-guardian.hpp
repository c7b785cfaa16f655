// SPDX-License-Identifier: LGPL-2.1-or-later
// The guardian of a program that is killed: another process drives the device.
#pragma once

#include "promises.hpp"

#include <optional>
#include <spidar/error.hpp>
#include <sys/types.h>
#include <thread>
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

/// How long a guardian may keep the device.
inline constexpr std::chrono::milliseconds kPatience{5000};

/// Calls `open` until it succeeds: a guardian keeps the device until it has set minimum tension.
/// Throws what `open` throws in the end.
template <class Open>
auto open_again(const Open &open, std::chrono::milliseconds patience = kPatience) {
  for (const auto begin = Clock::now();;) {
    try {
      return open();
    } catch (const spidar::Error &) {
      if (Clock::now() - begin > patience)
        throw;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

/// The device as another process drives it.
struct OtherProgram {
  /// Drives under a force, and calls `pulls` once it does; until it is killed.
  std::function<void(const std::function<void()> &pulls)> drive;
  /// Opens the device and closes it. Throws spidar::Error while another process holds it.
  std::function<void()> open;
  Clock::duration mean_exchange{};
  std::chrono::milliseconds patience = kPatience; ///< with its guardian
  std::chrono::milliseconds felt{2000};           ///< a person notices the pull
};

/// Kills that program's process group. No device may be open. `ask` may be empty.
void check_kill(const OtherProgram &program, const Ask &ask, const Report &report);

} // namespace spidar_check
