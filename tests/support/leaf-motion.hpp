// SPDX-License-Identifier: LGPL-2.1-or-later
// The leaf as a tracker sees it, and the force that the loop makes of it.
#pragma once

#include "leaf.hpp"
#include "loop/haptic-loop.hpp"

#include <cmath>
#include <optional>
#include <random>
#include <vector>

namespace test {

inline constexpr std::int64_t kMillisecond = 1'000'000; // ns

inline haptic::MotionSample seen(double velocity, double interval) {
  haptic::MotionSample sample;
  sample.velocity_x = static_cast<float>(velocity);
  sample.confidence = 1;
  sample.interval = static_cast<std::uint64_t>(interval * 1e9);
  sample.frame_width = 352;
  sample.frame_height = 288;
  return sample;
}

/// One frame, when the sink is told of it and when it is due.
struct Shown {
  haptic::MotionSample sample;
  std::int64_t told = 0;                 // ns
  std::int64_t middle = haptic::kAtOnce; // ns
};

/// What a tracker says of the leaf: the displacement over each interval. `look_ahead` in intervals;
/// none: each frame counts when it comes.
inline std::vector<Shown> film_leaf(double fps, double seconds, std::optional<double> look_ahead,
                                    double noise = 0) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal; // a standard deviation of 0 is not allowed
  const auto error = [&] { return noise * normal(random); };
  std::vector<Shown> frames;
  double before = Leaf::position(0) + error();
  const double interval = 1 / fps;
  for (int n = 1; n * interval < seconds; ++n) {
    const double pts = n * interval;
    const double now = Leaf::position(pts) + error();
    Shown shown{.sample = seen((now - before) / interval, interval)};
    before = now;
    shown.told = std::llround((pts - look_ahead.value_or(0) * interval) * 1e9);
    if (look_ahead)
      shown.middle = std::llround((pts - interval / 2) * 1e9);
    frames.push_back(shown);
  }
  return frames;
}

/// The force along x at each millisecond.
inline std::vector<double> feel(const std::vector<Shown> &frames, double seconds,
                                const haptic::LoopSettings &settings = {}) {
  haptic::HapticLoop loop;
  loop.prepare({});
  loop.set_settings(settings);
  loop.unhold(haptic::kHoldClosed | haptic::kHoldPaused);
  std::vector<double> forces;
  std::size_t next = 0;
  for (std::int64_t now = 0; now < std::llround(seconds * 1e9); now += kMillisecond) {
    for (; next < frames.size() && frames[next].told <= now; ++next)
      loop.submit(frames[next].sample, now, frames[next].middle);
    loop.tick(now, now);
    forces.push_back(loop.wrench().force.x());
  }
  return forces;
}

} // namespace test
