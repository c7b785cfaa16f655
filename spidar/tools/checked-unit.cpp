// SPDX-License-Identifier: LGPL-2.1-or-later
#include "checked-unit.hpp"

#include "device-name.hpp"

#include <algorithm>
#include <cstdlib>
#include <thread>

namespace spidar_check {

using namespace std::chrono_literals;
using spidar::Vector3;

namespace {

constexpr auto kTick = 1ms;
constexpr double kRamp = 2;      // N/s
constexpr double kLetGoAt = 1.0; // m/s

/// Hands everything on to another controller, and records it.
class Recorder final : public spidar::Controller {
public:
  Recorder(std::unique_ptr<spidar::Controller> inner, std::shared_ptr<Record> record)
      : inner_(std::move(inner)), record_(std::move(record)) {}

  bool exchange(const spidar::DacWords &words, spidar::Counts &counts) noexcept override {
    const auto begin = Clock::now();
    const bool answered = inner_->exchange(words, counts);
    const auto end = Clock::now();
    Record &record = *record_;
    ++record.exchanges;
    record.last = words;
    record.last_answered = answered;
    for (const std::int16_t word : words)
      record.largest_word = std::max(record.largest_word, std::abs(int{word}));
    if (answered) {
      record.failed_in_a_row = 0;
      record.longest = std::max(record.longest, end - begin);
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
  std::string description() const override { return inner_->description(); }

private:
  std::unique_ptr<spidar::Controller> inner_;
  std::shared_ptr<Record> record_;
};

} // namespace

Unit::Unit(const spidar_tools::Choice &choice) : paced_(choice.device != "sim") {
  const spidar::Geometry geometry = spidar::load_geometry(choice.geometry);
  auto controller = spidar::open_controller(choice.device, geometry, choice.sim_hand);
  device_ = std::make_unique<spidar::Device>(
      std::make_unique<Recorder>(std::move(controller), record_), geometry);
  next_ = Clock::now();
}

bool Unit::exchange() {
  const bool answered =
      device_->exchange(paced_ ? spidar::monotonic_time() : simulated_ += 1000000);
  const spidar::DeviceState &state = device_->state();
  valid_ticks_ += state.valid ? 1 : 0;
  lowest_ = std::min(lowest_, state.tensions.minCoeff());
  highest_ = std::max(highest_, state.tensions.maxCoeff());
  if (state.interrupted) {
    ++interruptions_;
    force_.setZero();
  }
  return answered;
}

void Unit::tick(const Vector3 &wanted) {
  if (paced_) {
    next_ = std::max(next_ + kTick, Clock::now() - kTick); // no burst after a pause
    std::this_thread::sleep_until(next_);
  }
  exchange();
  const spidar::DeviceState &state = device_->state();
  let_go_ = let_go_ || (state.velocity.norm() > kLetGoAt && force_.norm() > 0);
  const Vector3 change = (let_go_ ? Vector3(Vector3::Zero()) : wanted) - force_;
  force_ += change * std::min(1.0, kRamp * 1e-3 / std::max(change.norm(), 1e-9));
  device_->command({force_, Vector3::Zero()});
}

void Unit::run(double seconds, const Vector3 &wanted) {
  for (int i = 0; i < static_cast<int>(seconds * 1e3); ++i) {
    tick(wanted);
    if (!connected())
      spidar::fail(spidar::Cause::io, spidar::messages::kToolSilent);
  }
}

} // namespace spidar_check
