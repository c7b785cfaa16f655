// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion fields of leaves in the wind: some cells swing, most rest, and all are measured with an
// error of 0.02 px. The same ones for each seed.
#pragma once

#include "samples/motion-field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace test {

class LeafFields {
public:
  static constexpr std::uint64_t kInterval = 33'333'333; // ns
  static constexpr std::uint16_t kColumns = 32;
  static constexpr std::uint16_t kRows = 18;

  /// `share` of the frame is leaves, which swing at up to `amplitude` px per frame.
  explicit LeafFields(unsigned seed, double share = 0.25, double amplitude = 2) : random_(seed) {
    for (double area = 0; area < share * kColumns * kRows;) {
      Leaf leaf;
      leaf.x = number(0, kColumns);
      leaf.y = number(0, kRows);
      leaf.radius = number(1.5, 3.5);
      leaf.frequency = number(0.5, 2);
      leaf.phase = number(0, 2 * std::numbers::pi);
      leaf.amplitude = amplitude * number(0.3, 1);
      leaf.direction = number(0, 2 * std::numbers::pi);
      leaves_.push_back(leaf);
      area += std::numbers::pi * leaf.radius * leaf.radius;
    }
  }

  haptic::MotionField next() {
    haptic::MotionField field;
    field.interval = frame_ > 0 ? kInterval : 0;
    field.flags = frame_ > 0 ? 0 : haptic::kMotionDiscontinuity;
    field.frame_width = 1920;
    field.frame_height = 1080;
    field.columns = kColumns;
    field.rows = kRows;
    for (int i = 0; i < kColumns * kRows; ++i)
      field.cells.push_back(frame_ > 0 ? cell(i % kColumns + 0.5, i / kColumns + 0.5)
                                       : haptic::FieldCell{});
    ++frame_;
    return field;
  }

private:
  struct Leaf {
    double x, y, radius; // cells
    double frequency;    // Hz
    double phase;
    double amplitude; // px per frame
    double direction;
  };

  haptic::FieldCell cell(double x, double y) {
    const double time = frame_ * 1e-9 * kInterval;
    std::normal_distribution<double> noise(0, 0.02); // px
    double right = noise(random_);
    double down = noise(random_);
    for (const Leaf &leaf : leaves_) {
      const double distance = std::hypot(x - leaf.x, y - leaf.y) / leaf.radius;
      if (distance > 1)
        continue;
      const double angle = 2 * std::numbers::pi * leaf.frequency * time + leaf.phase;
      const double speed = leaf.amplitude * (0.5 + 0.5 * std::cos(std::numbers::pi * distance)) *
                           (std::sin(angle) + 0.4 * std::sin(2.3 * angle));
      right += speed * std::cos(leaf.direction);
      down += speed * std::sin(leaf.direction);
    }
    const double confidence = 0.7 + 0.25 * std::sin(0.4 * x) * std::cos(0.5 * y) + noise(random_);
    const double frames = 1e9 / kInterval; // a second
    return {static_cast<float>(right * frames), static_cast<float>(down * frames),
            static_cast<float>(std::clamp(confidence, 0.0, 1.0))};
  }
  double number(double lowest, double highest) {
    return std::uniform_real_distribution<double>(lowest, highest)(random_);
  }

  std::mt19937 random_;
  std::vector<Leaf> leaves_;
  int frame_ = 0;
};

} // namespace test
