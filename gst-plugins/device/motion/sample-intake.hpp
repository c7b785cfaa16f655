// SPDX-License-Identifier: LGPL-2.1-or-later
// From the bytes of a sample or field and its presentation time to a motion for the loop.
#pragma once

#include "motion/cadence.hpp"
#include "motion/playback-rate.hpp"
#include "motion/timed-motion.hpp"
#include "share/field-pool.hpp"
#include "share/shared-value.hpp"

#include <cstdint>
#include <optional>
#include <span>

namespace haptic {

/// When samples are felt (property `latency-mode`).
enum class LatencyMode {
  automatic,    ///< immediate if the source is live, else synchronized
  synchronized, ///< with their frames
  immediate,    ///< as soon as they come
};

/// Returns whether samples are felt as soon as they come. `live` is asked only if it matters.
template <typename Live>
bool is_immediate(LatencyMode mode, bool sync, Live &&live) {
  if (!sync)
    return true;
  return mode == LatencyMode::automatic ? live() : mode == LatencyMode::immediate;
}

/// How and when a frame is presented.
struct Presentation {
  std::int64_t time = kAtOnce; ///< running time, ns
  Playback playback;
  RateLaw rate_law = RateLaw::as_seen;
};

/// The state of one stream: a start replaces it. Streaming thread; the counters are read by any
/// thread.
class SampleIntake {
public:
  /// `fields` outlives every motion that accept() returns.
  explicit SampleIntake(FieldPool &fields) noexcept : fields_(&fields) {}

  /// The layout of the bytes, from the caps.
  void set_layout(bool holds_fields) noexcept { holds_fields_ = holds_fields; }
  /// The duration of a frame from the caps, ns: a first estimate of the look-ahead.
  void set_frame_duration(std::uint64_t duration) noexcept;

  struct Result {
    std::optional<TimedMotion> motion; ///< for the loop; nothing for a repeated frame
    bool damaged = false;              ///< the bytes cannot be used
    bool lost = false;                 ///< the loop stands still, and holds all fields
  };
  /// One frame, in the order of the stream. `gap`: the buffer has the GAP flag.
  Result accept(std::span<const std::uint8_t> bytes, bool gap, const Presentation &presentation);
  /// Nothing was measured at this time; `sample` gives the reason.
  TimedMotion accept_gap(std::int64_t time, const MotionSample &sample = {}) noexcept;

  /// Returns the running time by which frames should come early, ns: 1.5 intervals, so that a
  /// motion is known when it has to begin.
  std::uint64_t look_ahead() const noexcept { return look_ahead_; }

  std::uint64_t samples() const noexcept { return samples_.load(); }         ///< readable, no gap
  std::uint64_t bad_samples() const noexcept { return bad_samples_.load(); } ///< damaged
  std::uint64_t gaps() const noexcept { return gaps_.load(); }

private:
  bool read(std::span<const std::uint8_t> bytes, TimedMotion &motion);
  void extend_look_ahead(std::uint64_t interval) noexcept;

  FieldPool *fields_;
  bool holds_fields_ = false;
  Cadence cadence_;
  HeldPlace held_;                  // of the frame before
  std::uint64_t last_interval_ = 0; // ns, of the frame before
  std::uint64_t look_ahead_ = 0;    // ns
  SharedValue<std::uint64_t> samples_;
  SharedValue<std::uint64_t> bad_samples_;
  SharedValue<std::uint64_t> gaps_;
};

} // namespace haptic
