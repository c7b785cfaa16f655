// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion samples with something in every field, the same ones for each seed. Nothing is held in
// about every sixth.
#pragma once

#include "core/track-sample.hpp"

#include <random>

namespace test {

class TrackSamples {
public:
  explicit TrackSamples(unsigned seed) : random_(seed) {}

  haptic::TrackSample next() {
    using haptic::MotionModel;
    haptic::TrackSample sample;
    haptic::MotionSample &s = sample.motion;
    s.velocity_x = number(-500, 500);
    s.velocity_y = number(-500, 500);
    s.spin = number(-3, 3);
    s.divergence = number(-3, 3);
    s.pointer_x = number(0, 1);
    s.pointer_y = number(0, 1);
    s.region_width = number(0, 1);
    s.region_height = number(0, 1);
    s.confidence = number(0, 1);
    s.interval = random_();
    s.frame_width = count(4096);
    s.frame_height = count(4096);
    s.pixel_aspect_n = count(100);
    s.pixel_aspect_d = count(100);
    s.points = static_cast<std::uint16_t>(random_());
    s.flags = static_cast<std::uint16_t>(random_() % 64);
    s.model = static_cast<MotionModel>(random_() % 5);
    sample.time = std::uint64_t{random_()} << 16 | random_() % 65536;
    sample.duration = random_();
    if (const auto state = static_cast<haptic::HoldState>(s.points % 6);
        state != haptic::HoldState::none)
      s.held = {state, s.pointer_y, s.pointer_x, s.region_height, sample.time / 2};
    return sample;
  }

private:
  std::uint32_t count(std::uint32_t most) {
    return static_cast<std::uint32_t>(1 + random_() % most);
  }
  float number(float lowest, float highest) {
    return std::uniform_real_distribution<float>(lowest, highest)(random_);
  }
  std::mt19937 random_;
};

} // namespace test
