// SPDX-License-Identifier: LGPL-2.1-or-later
#include "loop/tick-log.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <new>
#include <system_error>

namespace haptic {
namespace {

constexpr std::int64_t kDrainEvery = 20'000'000; // ns
constexpr int kDigits = 9;

void append_number(std::string &text, double value) {
  std::array<char, 32> digits{};
  // Adding zero turns -0 into 0.
  const auto end =
      std::to_chars(digits.begin(), digits.end(), std::isfinite(value) ? value + 0.0 : 0,
                    std::chars_format::general, kDigits)
          .ptr;
  if (!text.empty() && text.back() != '\n')
    text += ',';
  text.append(digits.begin(), end);
}

} // namespace

void append_row(std::string &text, const TickRow &row) {
  const auto append = [&text](const auto &values) {
    for (const double value : values)
      append_number(text, value);
  };
  append_number(text, row.time);
  append(row.position);
  append(row.velocity);
  append_number(text, row.spin);
  append(row.force);
  append(row.torque);
  append_number(text, row.confidence);
  append(row.tension);
  append_number(text, row.mono);
  append_number(text, row.hold);
  append(row.orientation);
  append_number(text, row.energy);
  append(row.turning);
  append(row.realised_force);
  append(row.realised_torque);
  append(row.proxy);
  append_number(text, row.touches ? 1 : 0);
  text += '\n';
}

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
