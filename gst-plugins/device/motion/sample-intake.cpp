// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/sample-intake.hpp"

#include "samples/field-sampler.hpp"

#include <algorithm>
#include <utility>

namespace haptic {
namespace {

// A line between two motions ends in the middle of the next interval, which is measured 1.5
// intervals after the line began.
constexpr double kLookAheadIntervals = 1.5;
constexpr std::uint64_t kLongestLookAhead = 750'000'000; // ns; queues hold 1 s

// The velocity is that of the middle of the interval.
std::int64_t middle_of(std::int64_t time, std::uint64_t interval) noexcept {
  return time == kAtOnce ? kAtOnce : time - static_cast<std::int64_t>(interval / 2);
}

} // namespace

void SampleIntake::set_frame_duration(std::uint64_t duration) noexcept {
  last_interval_ = duration;
  extend_look_ahead(duration);
}

// The look-ahead only grows, to what the stream needs. Of two intervals the shorter one counts: a
// single late frame must not extend it.
void SampleIntake::extend_look_ahead(std::uint64_t interval) noexcept {
  const std::uint64_t usual = std::min(interval, std::exchange(last_interval_, interval));
  const auto wanted = static_cast<std::uint64_t>(kLookAheadIntervals * static_cast<double>(usual));
  look_ahead_ = std::clamp(wanted, look_ahead_, kLongestLookAhead);
}

bool SampleIntake::read(std::span<const std::uint8_t> bytes, TimedMotion &motion) {
  if (motion.field) {
    if (!unpack_motion_field(bytes, *motion.field))
      return false;
    motion.sample = frame_of(*motion.field);
    return true;
  }
  const auto sample = unpack_motion_sample(bytes);
  motion.sample = sample.value_or(MotionSample{});
  return sample.has_value();
}

SampleIntake::Result SampleIntake::accept(std::span<const std::uint8_t> bytes, bool gap,
                                          const Presentation &presentation) {
  TimedMotion motion;
  if (holds_fields_) {
    motion.field = fields_->acquire();
    if (!motion.field)
      return {.motion = {}, .lost = true};
  }
  const bool readable = read(bytes, motion);
  if (!gap && (!readable || !is_plausible(motion))) {
    ++bad_samples_;
    return {TimedMotion{}, true};
  }
  samples_ += !gap;
  if (gap || !has_measurement(motion))
    return {accept_gap(presentation.time, motion.sample)};

  const double correction = cadence_.correction(motion.sample);
  const HeldPlace before = std::exchange(held_, motion.sample.held);
  const bool holds_on = held_.state == before.state &&
                        (held_.state == HoldState::none || is_same_thing(before, held_));
  if ((motion.sample.flags & kMotionDuplicate) && holds_on)
    return {}; // the motion before continues
  if (!apply_playback(motion, presentation.playback, presentation.rate_law))
    return {accept_gap(presentation.time)};
  scale_velocities(motion, correction);
  extend_look_ahead(motion.sample.interval);
  motion.measured = true;
  motion.time = middle_of(presentation.time, motion.sample.interval);
  return {std::move(motion)};
}

TimedMotion SampleIntake::accept_gap(std::int64_t time, const MotionSample &sample) noexcept {
  ++gaps_;
  cadence_.restart();
  held_ = sample.held;
  return {sample, false, middle_of(time, std::min(sample.interval, kLongestLookAhead))};
}

} // namespace haptic
