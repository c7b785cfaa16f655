// SPDX-License-Identifier: LGPL-2.1-or-later
// A device that spidar-check drives at 1 kHz, and a record of what was sent to its controller.
#pragma once

#include "model/gentle-pull.hpp"

#include <chrono>
#include <memory>
#include <spidar/device.hpp>
#include <spidar/limited-device.hpp>
#include <thread>

namespace spidar_check {

using Clock = std::chrono::steady_clock;

/// The time of a check.
class Timer {
public:
  virtual ~Timer() = default;
  virtual Clock::time_point now() const = 0;
  virtual void wait_until(Clock::time_point time) = 0;
};

class MachineTime final : public Timer {
public:
  Clock::time_point now() const override { return Clock::now(); }
  void wait_until(Clock::time_point time) override { std::this_thread::sleep_until(time); }
};

/// Advances by waiting only: of a simulated device.
class SimulatedTime : public Timer {
public:
  Clock::time_point now() const override { return now_; }
  void wait_until(Clock::time_point time) override { now_ = std::max(now_, time); }

private:
  Clock::time_point now_{};
};

/// What the controller was sent, and how it answered. Outlives the device.
struct Record {
  spidar::DacWords rest{}; ///< of minimum tension
  spidar::DacWords last{}; ///< sent last
  bool last_answered = false;
  long exchanges = 0;
  long failed = 0;
  int failed_in_a_row = 0;
  int most_failed_in_a_row = 0;
  int largest_word = 0;         ///< magnitude
  Clock::duration longest{};    ///< of an exchange that was answered
  Clock::duration total{};      ///< of all that were answered
  Clock::time_point answered{}; ///< the last time

  Clock::duration mean() const {
    return exchanges > failed ? total / (exchanges - failed) : Clock::duration();
  }
};

class Unit {
public:
  /// Throws spidar::Error.
  Unit(std::unique_ptr<spidar::Controller> controller, const spidar::Geometry &geometry,
       std::shared_ptr<Timer> timer);

  /// Waits for the next millisecond, exchanges, and brings the force closer to `wanted` (N), within
  /// the limits of LimitedDevice. The force goes off when the grip is let go or no pose is known,
  /// and begins from zero when the guardian has intervened.
  void tick(const spidar::Vector3 &wanted);
  /// Ticks for `seconds`. Throws spidar::Error (io) if the device is gone.
  void run(double seconds, const spidar::Vector3 &wanted);
  /// Exchanges at once.
  bool exchange();
  /// Exchanges nothing, as a program that hangs. Returns how long.
  Clock::duration pause(Clock::duration time);
  /// Commands what tick() would refuse.
  void command(const spidar::Wrench &wrench) { limited_->command(wrench); }

  const spidar::DeviceState &state() const { return device_->state(); }
  const spidar::Geometry &geometry() const { return device_->geometry(); }
  const Record &record() const { return *record_; }
  std::shared_ptr<const Record> shared_record() const { return record_; }
  std::string description() const { return device_->description(); }
  std::string remark() const { return device_->remark(); }
  bool connected() const { return device_->connected(); }
  Clock::time_point now() const { return timer_->now(); }

  long valid_ticks() const { return valid_ticks_; }
  double lowest_tension() const { return lowest_; }   ///< N
  double highest_tension() const { return highest_; } ///< N
  int interruptions() const { return interruptions_; }
  bool let_go() const { return let_go_; }
  double force() const { return limited_->wrench().force.norm(); } ///< N, as sent last
  /// Longest time between two exchanges of tick() so far, and since forget_gaps().
  Clock::duration longest_gap() const { return longest_gap_; }
  void forget_gaps();

private:
  std::shared_ptr<Timer> timer_;
  std::shared_ptr<Record> record_ = std::make_shared<Record>();
  std::unique_ptr<spidar::Device> device_;
  std::unique_ptr<spidar::LimitedDevice> limited_;
  Clock::time_point next_;
  Clock::time_point exchanged_;
  Clock::duration longest_gap_{};
  spidar::GentlePull pull_;
  double lowest_ = 1e9;
  double highest_ = 0;
  long valid_ticks_ = 0;
  int interruptions_ = 0;
  bool let_go_ = false;
};

} // namespace spidar_check
