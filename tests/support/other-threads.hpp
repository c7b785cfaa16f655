// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether the other threads of the program have anything left to do.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace test {

/// How often this thread (its directory in /proc) has gone to sleep. Nothing if it does not sleep.
inline std::optional<long> times_asleep(const std::filesystem::path &thread) {
  std::array<char, 4096> text;
  const int file = open((thread / "status").c_str(), O_RDONLY | O_CLOEXEC);
  const ssize_t size = read(file, text.data(), text.size() - 1);
  close(file);
  const std::string_view status(text.data(), size < 0 ? 0 : static_cast<std::size_t>(size));
  text[status.size()] = '\0';
  constexpr std::string_view kState = "\nState:\tS";
  constexpr std::string_view kSlept = "\nvoluntary_ctxt_switches:\t";
  const std::size_t slept = status.find(kSlept);
  if (status.find(kState) == std::string_view::npos || slept == std::string_view::npos)
    return std::nullopt; // it may have ended
  return std::atol(text.data() + slept + kSlept.size());
}

/// The other threads and how often each has gone to sleep. Nothing if one of them does not sleep.
inline std::optional<std::vector<std::pair<std::string, long>>> sleeping_threads() {
  std::vector<std::pair<std::string, long>> threads;
  const std::string self = std::to_string(gettid());
  for (const auto &entry : std::filesystem::directory_iterator("/proc/self/task")) {
    std::string number = entry.path().filename();
    if (number == self)
      continue;
    const auto times = times_asleep(entry.path());
    if (!times)
      return std::nullopt;
    threads.emplace_back(std::move(number), *times);
  }
  std::ranges::sort(threads);
  return threads;
}

/// Waits, as long as it takes, until all other threads sleep at the same time: what they were about
/// to do is done. Two looks that find each of them asleep, and not once awake in between, have seen
/// that. A thread that never sleeps keeps this one waiting.
inline void wait_for_other_threads() {
  for (auto before = sleeping_threads();;) {
    auto now = sleeping_threads();
    if (now && now == before)
      return;
    if (!now)
      std::this_thread::sleep_for(std::chrono::microseconds(20)); // leaves them the processor
    before = std::move(now);
  }
}

} // namespace test
