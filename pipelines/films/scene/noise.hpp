// SPDX-License-Identifier: LGPL-2.1-or-later
// Random numbers and smooth noise; the same from the same seed on every machine.
#pragma once

#include <cmath>
#include <cstdint>

namespace film {

/// SplitMix64 (Steele, Lea and Flood 2014).
constexpr std::uint64_t scramble(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

class Random {
public:
  explicit Random(std::uint64_t seed) : state_(scramble(seed)) {}

  /// Evenly in [low, high).
  float between(float low, float high) {
    state_ += 0x9e3779b97f4a7c15;
    return low + (high - low) * static_cast<float>(scramble(state_) >> 40) * 0x1p-24F;
  }
  /// One of 0 … count − 1.
  int below(int count) { return static_cast<int>(between(0, static_cast<float>(count))); }
  /// Mean 0, most within ±2: the sum of twelve even ones has variance 1.
  float normal() {
    float sum = -6;
    for (int i = 0; i < 12; ++i)
      sum += between(0, 1);
    return sum;
  }

private:
  std::uint64_t state_;
};

constexpr float mix(float a, float b, float share) {
  return a + (b - a) * share;
}

/// 0 up to `low`, 1 from `high` on, without a kink.
constexpr float smooth_step(float low, float high, float x) {
  const float t = x <= low ? 0 : x >= high ? 1 : (x - low) / (high - low);
  return t * t * (3 - 2 * t);
}

/// Value noise in 0..1 with features of size 1.
inline float noise(float x, float y, std::uint64_t seed) {
  const float left = std::floor(x);
  const float top = std::floor(y);
  const auto value = [&](float i, float j) {
    const auto column = static_cast<std::uint64_t>(static_cast<std::int64_t>(i));
    const auto line = static_cast<std::uint64_t>(static_cast<std::int64_t>(j));
    return static_cast<float>(scramble(column * 0x8da6b343 + line * 0xd8163841 + seed) >> 40) *
           0x1p-24F;
  };
  const float u = smooth_step(0, 1, x - left);
  const float v = smooth_step(0, 1, y - top);
  return mix(mix(value(left, top), value(left + 1, top), u),
             mix(value(left, top + 1), value(left + 1, top + 1), u), v);
}

/// Several octaves of noise, in 0..1.
inline float rough_noise(float x, float y, int octaves, std::uint64_t seed) {
  float sum = 0;
  float weight = 0.5F;
  float total = 0;
  for (int i = 0; i < octaves; ++i) {
    sum += weight * noise(x, y, seed + static_cast<std::uint64_t>(i));
    total += weight;
    weight /= 2;
    x *= 2.03F;
    y *= 2.03F;
  }
  return sum / total;
}

} // namespace film
