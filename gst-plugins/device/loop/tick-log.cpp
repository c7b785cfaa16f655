// SPDX-License-Identifier: LGPL-2.1-or-later
#include "loop/tick-log.hpp"

#include <cerrno>
#include <new>
#include <system_error>

namespace haptic {
namespace {

constexpr std::int64_t kDrainEvery = 20'000'000; // ns

} // namespace

TickLog::TickLog(const std::string &path, LoopClock &clock)
    : file_(std::fopen(path.c_str(), "we")), rows_(kRows), clock_(clock) {
  if (!file_)
    throw std::system_error(errno, std::generic_category(), path);
  put(std::string(kTickLogHeader) + '\n');
  // Reports a full disk now.
  if (error())
    throw std::system_error(error(), std::generic_category(), path);
  thread_ = std::jthread([this](const std::stop_token &stop) { run(stop); });
}

TickLog::~TickLog() = default; // the thread is the last member: it ends and is joined first

bool TickLog::write(const TickRow &row) noexcept {
  const std::size_t at = written_.load(std::memory_order_relaxed);
  if (at - read_.load(std::memory_order_acquire) == kRows)
    return false;
  rows_[at % kRows] = row;
  written_.store(at + 1, std::memory_order_release);
  return true;
}

void TickLog::run(const std::stop_token &stop) try {
  std::string text;
  while (!stop.stop_requested()) {
    clock_.wait_until(clock_.now() + kDrainEvery, stop);
    drain(text);
  }
  drain(text);
} catch (const std::bad_alloc &) {
  error_.store(ENOMEM, std::memory_order_relaxed);
}

void TickLog::drain(std::string &text) {
  text.clear();
  std::size_t at = read_.load(std::memory_order_relaxed);
  for (const std::size_t end = written_.load(std::memory_order_acquire); at != end; ++at)
    append_row(text, rows_[at % kRows]);
  read_.store(at, std::memory_order_release);
  if (!text.empty() && !error())
    put(text);
}

void TickLog::put(const std::string &text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size() ||
      std::fflush(file_.get()) != 0)
    error_.store(errno ? errno : EIO, std::memory_order_relaxed);
}

} // namespace haptic
