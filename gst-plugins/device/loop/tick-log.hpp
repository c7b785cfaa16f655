// SPDX-License-Identifier: LGPL-2.1-or-later
// The CSV log: rows come from the real-time thread, a thread of normal priority writes them.
#pragma once

#include "loop/tick-row.hpp"
#include "non-blocking.hpp"
#include "share/loop-clock.hpp"

#include <atomic>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace haptic {

class TickLog {
public:
  /// Creates the file and writes the header. `clock` outlives the log. Throws std::system_error.
  explicit TickLog(const std::string &path, LoopClock &clock = machine_clock());
  /// Writes the rows that are left and closes the file.
  ~TickLog();
  TickLog(const TickLog &) = delete;
  TickLog &operator=(const TickLog &) = delete;

  /// Returns false if the row is lost because the writer is too far behind. One thread; real-time
  /// safe.
  bool write(const TickRow &row) noexcept HAPTIC_NONBLOCKING;

  /// Writes the rows that are left. None may come afterwards.
  void finish() { thread_ = {}; }

  /// Returns the errno of the first write that failed (nothing is written after it), or 0.
  int error() const noexcept { return error_.load(std::memory_order_relaxed); }

private:
  // At the highest rate, 4 kHz, this is two seconds of a stuck disk.
  static constexpr std::size_t kRows = 8192;

  struct CloseFile {
    void operator()(std::FILE *file) const noexcept { std::fclose(file); }
  };

  void run(const std::stop_token &stop);
  void drain(std::string &text);
  void put(const std::string &text);

  std::unique_ptr<std::FILE, CloseFile> file_;       // writer thread after construction
  std::vector<TickRow> rows_;                        // ring; a row belongs to one side at a time
  alignas(64) std::atomic<std::size_t> written_ = 0; // rows ever put in, by write()
  alignas(64) std::atomic<std::size_t> read_ = 0;    // rows ever taken out, by the writer thread
  std::atomic<int> error_ = 0;
  LoopClock &clock_;
  std::jthread thread_;
};

} // namespace haptic
