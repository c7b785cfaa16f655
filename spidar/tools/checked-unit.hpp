// SPDX-License-Identifier: LGPL-2.1-or-later
// A device that spidar-check drives at 1 kHz, and a record of what was sent to its controller.
#pragma once

#include "tool.hpp"

#include <chrono>

namespace spidar_check {

using Clock = std::chrono::steady_clock;

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
  Clock::time_point answered{}; ///< the last time
};

class Unit {
public:
  /// Throws spidar::Error.
  explicit Unit(const spidar_tools::Choice &choice);

  /// Waits for the next millisecond (a simulated device has its own time), exchanges, and brings
  /// the force closer to `wanted` (N). The force goes off when the grip is let go or the guardian
  /// has intervened.
  void tick(const spidar::Vector3 &wanted);
  /// Ticks for `seconds`. Throws spidar::Error (io) if the device is gone.
  void run(double seconds, const spidar::Vector3 &wanted);
  /// Exchanges at once.
  bool exchange();
  /// Commands what tick() would refuse.
  void command(const spidar::Wrench &wrench) { device_->command(wrench); }

  const spidar::DeviceState &state() const { return device_->state(); }
  const spidar::Geometry &geometry() const { return device_->geometry(); }
  const Record &record() const { return *record_; }
  std::shared_ptr<const Record> shared_record() const { return record_; }
  std::string description() const { return device_->description(); }
  bool connected() const { return device_->connected(); }

  long valid_ticks() const { return valid_ticks_; }
  double lowest_tension() const { return lowest_; }   ///< N
  double highest_tension() const { return highest_; } ///< N
  int interruptions() const { return interruptions_; }
  bool let_go() const { return let_go_; }

private:
  std::shared_ptr<Record> record_ = std::make_shared<Record>();
  std::unique_ptr<spidar::Device> device_;
  bool paced_;
  Clock::time_point next_ = Clock::now();
  std::int64_t simulated_ = 0; ///< ns
  spidar::Vector3 force_ = spidar::Vector3::Zero();
  double lowest_ = 1e9;
  double highest_ = 0;
  long valid_ticks_ = 0;
  int interruptions_ = 0;
  bool let_go_ = false;
};

} // namespace spidar_check
