// SPDX-License-Identifier: LGPL-2.1-or-later
// The mechanics behind a controller: grip, strings and hand of the simulator.
//
// By the machine's clock they move while the host asks, and stand still after 20 ms without a
// question: a slow machine then has a slow hand and no late reply. By the question they move 1 ms
// for each, whatever time it takes: a test is then the same on every machine.
#pragma once

#include "spidar/simulator.hpp"

#include <chrono>

namespace emulator {

using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;

class Plant {
public:
  enum class Pace { machine_clock, question };

  /// Throws spidar::Error (geometry).
  Plant(const spidar::Geometry &geometry, std::unique_ptr<spidar::HandScript> hand,
        Pace pace = Pace::machine_clock);

  /// Sets the D/A words at the motors; those beyond the D/A's range saturate.
  void set(const spidar::DacWords &words, Time now);

  /// Encoder counts in the geometry's direction, with an arbitrary origin.
  const spidar::Counts &counts(Time now);

  /// The input pins that the button of the geometry is wired to, and what the hand makes of them.
  std::uint16_t wired() const noexcept { return wired_; }
  std::uint16_t inputs() const noexcept { return simulator_->inputs(); }

  /// The true pose of the grip.
  const spidar::Pose &pose() const noexcept { return simulator_->pose(); }

private:
  void advance(Time now);

  Pace pace_;
  int dac_limit_;
  std::uint16_t wired_;
  std::unique_ptr<spidar::Simulator> simulator_;
  bool started_ = false;
  Time simulated_{};
  spidar::DacWords words_{};
  spidar::Counts counts_{};
};

} // namespace emulator
