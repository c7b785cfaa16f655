// SPDX-License-Identifier: LGPL-2.1-or-later
#include "checked-unit.hpp"

#include "fail.hpp"

#include <algorithm>
#include <cstdlib>
#include <spidar/spidar.h>

namespace spidar_check {

using namespace std::chrono_literals;
using spidar::Vector3;

namespace {

constexpr auto kTick = 1ms;

/// Hands everything on to another controller, and records it.
class Recorder final : public spidar::Controller {
public:
  Recorder(std::unique_ptr<spidar::Controller> inner, std::shared_ptr<Record> record,
           std::shared_ptr<Timer> timer)
      : inner_(std::move(inner)), record_(std::move(record)), timer_(std::move(timer)) {}

  bool exchange(const spidar::DacWords &words, spidar::Counts &counts) noexcept override {
    const auto begin = timer_->now();
    const bool answered = inner_->exchange(words, counts);
    const auto end = timer_->now();
    Record &record = *record_;
    ++record.exchanges;
    record.last = words;
    record.last_answered = answered;
    for (const std::int16_t word : words)
      record.largest_word = std::max(record.largest_word, std::abs(int{word}));
    if (answered) {
      record.failed_in_a_row = 0;
      record.longest = std::max(record.longest, end - begin);
      record.total += end - begin;
      record.answered = end;
    } else {
      ++record.failed;
      record.most_failed_in_a_row = std::max(record.most_failed_in_a_row, ++record.failed_in_a_row);
    }
    return answered;
  }
  bool home(spidar::Counts &counts) const noexcept override { return inner_->home(counts); }
  void guard(const spidar::DacWords &rest) override {
    record_->rest = rest;
    inner_->guard(rest);
  }
  bool connected() const noexcept override { return inner_->connected(); }
  void set_time(std::int64_t now) noexcept override { inner_->set_time(now); }
  bool interrupted() noexcept override { return inner_->interrupted(); }
  bool pressed() const noexcept override { return inner_->pressed(); }
  std::string description() const override { return inner_->description(); }
  std::string remark() const override { return inner_->remark(); }
  std::string identity() const override { return inner_->identity(); }
  std::uint16_t inputs() const noexcept override { return inner_->inputs(); }

private:
  std::unique_ptr<spidar::Controller> inner_;
  std::shared_ptr<Record> record_;
  std::shared_ptr<Timer> timer_;
};

} // namespace

Unit::Unit(std::unique_ptr<spidar::Controller> controller, const spidar::Geometry &geometry,
           std::shared_ptr<Timer> timer)
    : timer_(std::move(timer)),
      device_(std::make_unique<spidar::Device>(
          std::make_unique<Recorder>(std::move(controller), record_, timer_), geometry)),
      limited_(std::make_unique<spidar::LimitedDevice>(*device_)), next_(timer_->now()),
      exchanged_(next_) {}

bool Unit::exchange() {
  const auto now = timer_->now();
  longest_gap_ = std::max(longest_gap_, now - exchanged_);
  exchanged_ = now;
  const bool answered =
      limited_->exchange(std::chrono::nanoseconds(now.time_since_epoch()).count());
  const spidar::DeviceState &state = device_->state();
  valid_ticks_ += state.valid ? 1 : 0;
  lowest_ = std::min(lowest_, state.tensions.minCoeff());
  highest_ = std::max(highest_, state.tensions.maxCoeff());
  let_go_ = let_go_ || (limited_->holds() & SPIDAR_HOLD_LET_GO);
  pull_.release_if_unsafe(state, limited_->armed());
  if (state.interrupted) {
    ++interruptions_;
    limited_->command({}); // a next exchange without tick() must not send what was commanded before
  }
  return answered;
}

Clock::duration Unit::pause(Clock::duration time) {
  const auto begin = exchanged_;
  timer_->wait_until(begin + time);
  const auto length = timer_->now() - begin;
  forget_gaps();
  return length;
}

void Unit::forget_gaps() {
  exchanged_ = timer_->now();
  longest_gap_ = {};
}

void Unit::tick(const Vector3 &wanted) {
  next_ = std::max(next_ + kTick, timer_->now() - kTick); // no burst after a pause
  timer_->wait_until(next_);
  // A person may have been asked something since the exchange before.
  const double elapsed =
      std::chrono::duration<double>(std::min<Clock::duration>(timer_->now() - exchanged_, 5ms))
          .count();
  exchange();
  const bool may_pull = !let_go_ && device_->state().valid;
  pull_.want(may_pull ? wanted : Vector3::Zero());
  limited_->command({pull_.step(elapsed), Vector3::Zero()});
}

void Unit::run(double seconds, const Vector3 &wanted) {
  const auto end = timer_->now() + std::chrono::duration<double>(seconds);
  while (timer_->now() < end) {
    tick(wanted);
    if (!connected())
      spidar::fail(spidar::Cause::io, spidar::messages::kToolSilent);
  }
}

} // namespace spidar_check
