// SPDX-License-Identifier: LGPL-2.1-or-later
// Counts durations; percentiles can be read while it counts.
#pragma once

#include "share/shared-value.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace haptic {

/// Buckets of 1/16 octave from 1 ns to 18 minutes: a percentile is at most 6 % too high, never too
/// low. One thread records (real-time safe), any thread reads.
class DurationHistogram {
  static constexpr int kStepBits = 4;
  static constexpr std::uint64_t kSteps = 1U << kStepBits; // per octave
  static constexpr int kOctaves = 36;
  static constexpr std::size_t kBuckets = (kOctaves + 1) * kSteps;

public:
  /// How many durations each bucket has counted.
  using Counts = std::array<std::uint64_t, kBuckets>;

  void record(std::int64_t nanoseconds) noexcept {
    const auto duration = static_cast<std::uint64_t>(nanoseconds > 0 ? nanoseconds : 0);
    bump(buckets_[bucket_of(duration)]);
    if (duration > max_.load(std::memory_order_relaxed))
      max_.store(duration, std::memory_order_relaxed);
  }

  Counts counts() const noexcept {
    Counts counts;
    for (std::size_t i = 0; i < kBuckets; ++i)
      counts[i] = buckets_[i].load(std::memory_order_relaxed);
    return counts;
  }

  /// Returns the duration in µs that the fraction `p` (0..1) of the records after counts() was
  /// `before` does not exceed; 0 without records.
  double percentile_us(double p, const Counts &before = {}) const noexcept {
    const Counts now = counts();
    std::uint64_t total = 0;
    for (std::size_t i = 0; i < kBuckets; ++i)
      total += now[i] - before[i];
    if (total == 0)
      return 0;
    const auto wanted = static_cast<std::uint64_t>(std::ceil(p * static_cast<double>(total)));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      seen += now[i] - before[i];
      if (seen >= wanted)
        return std::min(static_cast<double>(upper_end(i)) * 1e-3, max_us());
    }
    return max_us();
  }

  double max_us() const noexcept {
    return static_cast<double>(max_.load(std::memory_order_relaxed)) * 1e-3;
  }

private:
  // The first 16 buckets are one nanosecond wide; then every octave has 16.
  static std::size_t bucket_of(std::uint64_t duration) noexcept {
    if (duration < kSteps)
      return duration;
    const int octave = static_cast<int>(std::bit_width(duration)) - kStepBits; // 1, 2, ...
    if (octave > kOctaves)
      return kBuckets - 1;
    return static_cast<std::size_t>(octave) * kSteps + ((duration >> (octave - 1)) - kSteps);
  }
  static std::uint64_t upper_end(std::size_t bucket) noexcept {
    if (bucket < kSteps)
      return bucket;
    const std::size_t octave = bucket / kSteps;
    return ((bucket % kSteps + kSteps + 1) << (octave - 1)) - 1;
  }
  // A single writer needs no read-modify-write instruction.
  static void bump(SharedValue<std::uint64_t> &counter) noexcept {
    counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  std::array<SharedValue<std::uint64_t>, kBuckets> buckets_{};
  SharedValue<std::uint64_t> max_ = 0; // ns
};

} // namespace haptic
