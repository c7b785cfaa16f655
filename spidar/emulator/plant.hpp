// SPDX-License-Identifier: LGPL-2.1-or-later
// The simulator's grip, strings and hand on the clock of the host's questions. They stand still
// while nobody asks for more than 20 ms, so that a slow machine is a slow hand and not a late
// reply.
#pragma once

#include "spidar/simulator.hpp"
#include "word-log.hpp"

namespace emulator {

class Plant {
public:
  /// Throws spidar::Error (geometry).
  Plant(const spidar::Geometry &geometry, std::unique_ptr<spidar::HandScript> hand);

  /// D/A words at the motors from now on; those beyond the D/A's range saturate.
  void set(const spidar::DacWords &words, Time now);

  /// Encoder counts as the geometry counts, from some number on.
  const spidar::Counts &counts(Time now);

private:
  void advance(Time now);

  int dac_limit_;
  std::unique_ptr<spidar::Simulator> simulator_;
  bool started_ = false;
  Time simulated_{};
  spidar::DacWords words_{};
  spidar::Counts counts_{};
};

} // namespace emulator
