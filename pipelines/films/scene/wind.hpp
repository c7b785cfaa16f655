// SPDX-License-Identifier: LGPL-2.1-or-later
// Gusts that cross the frame from left to right, and what sways in them.
#pragma once

#include "scene/noise.hpp"

#include <algorithm>
#include <array>

namespace film {

/// The wind at one time: some 0.3 (a breath) to 1.2 (a gust).
class Wind {
public:
  /// `time` in s.
  Wind(std::uint64_t seed, double time) : time_(time) {
    const std::uint64_t place = scramble(seed ^ 0x77696e64);
    for (std::size_t i = 0; i < strength_.size(); ++i) {
      constexpr float kSpeed = 380; // px/s
      const auto t = static_cast<float>(time) - (static_cast<float>(i) * kStep + kLeft) / kSpeed;
      const float gust = smooth_step(0.25F, 0.85F, noise(t * 0.42F + 0.6F, 0.5F, place));
      strength_[i] = 0.27F + 0.72F * gust + 0.25F * noise(t * 1.3F, 7.5F, place);
    }
  }

  /// At x in px of a frame 960 px wide.
  float operator()(float x) const {
    const float at = std::clamp((x - kLeft) / kStep, 0.0F, kCount - 1.01F);
    const auto whole = static_cast<std::size_t>(at);
    return mix(strength_[whole], strength_[whole + 1], at - static_cast<float>(whole));
  }

  /// Phase in rad of a swing of this frequency (Hz).
  float phase(float frequency) const {
    const double turns = time_ * static_cast<double>(frequency);
    return static_cast<float>((turns - std::floor(turns)) * 6.283185307179586);
  }

private:
  static constexpr float kLeft = -640;
  static constexpr float kStep = 8;
  static constexpr int kCount = 280;

  double time_;
  std::array<float, kCount> strength_;
};

/// A frame's wind and that of the frame before.
struct Winds {
  Wind now;
  Wind before;
};

/// A thing that the wind bends and that swings about there.
struct Sway {
  float lean = 0;      // at wind 1
  float swing = 0;     // at wind 1
  float frequency = 1; // Hz
  float phase = 0;     // rad
  float x = 0;         // where it feels the wind

  float operator()(const Wind &wind) const {
    const float strength = wind(x);
    return lean * (strength - 0.5F) +
           swing * strength *
               (0.75F * std::sin(wind.phase(frequency) + phase) +
                0.45F * std::sin(wind.phase(frequency * 0.618F) + 2 * phase));
  }
};

} // namespace film
