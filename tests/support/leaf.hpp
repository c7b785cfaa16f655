// SPDX-License-Identifier: LGPL-2.1-or-later
// A leaf in the wind.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace test {

/// Four swings between 0.4 and 4 Hz; with the default law 0.38 N rms and up to 11 N/s.
class Leaf {
public:
  /// px/s
  static double velocity(double t) {
    double v = 0;
    for (const Swing &s : kSwings)
      v += s.speed * std::cos(2 * std::numbers::pi * s.frequency * t + s.phase);
    return v;
  }
  /// px
  static double position(double t) {
    double x = 0;
    for (const Swing &s : kSwings)
      x += s.speed / (2 * std::numbers::pi * s.frequency) *
           std::sin(2 * std::numbers::pi * s.frequency * t + s.phase);
    return x;
  }
  /// N, the paper's equation 5 of the true velocity
  static double force(double t) { return 2 / std::numbers::pi * std::atan(0.01 * velocity(t)); }

private:
  struct Swing {
    double frequency; // Hz
    double speed;     // px/s
    double phase;     // rad
  };
  static constexpr std::array kSwings = {Swing{0.4, 60, 0.3}, Swing{1.1, 80, 1.1},
                                         Swing{2.3, 40, 2.2}, Swing{4, 30, 0.7}};
};

} // namespace test
