// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/motion-interpolator.hpp"

#include "samples/field-sampler.hpp"
#include "seconds.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptic {
namespace {

constexpr std::int64_t kLongestRamp = 1'000'000'000; // ns
constexpr std::int64_t kFarthest = 3'000'000'000;    // ns; a later time is wrong
constexpr std::int64_t kClosestInIntervals = 4;      // closer ones would make a step

std::int64_t interval_of(const MotionSample &sample) noexcept {
  return static_cast<std::int64_t>(std::min<std::uint64_t>(sample.interval, kLongestRamp));
}

void rescale(MotionSample &sample, const MotionSample &frame) noexcept {
  const bool same = sample.frame_width == frame.frame_width &&
                    sample.pixel_aspect_n == frame.pixel_aspect_n &&
                    sample.pixel_aspect_d == frame.pixel_aspect_d;
  if (same || sample.frame_width == 0)
    return;
  const double x = static_cast<double>(frame.frame_width) / sample.frame_width;
  const double y = x * sample.pixel_aspect_d / sample.pixel_aspect_n * frame.pixel_aspect_n /
                   frame.pixel_aspect_d;
  sample.velocity_x = static_cast<float>(x * sample.velocity_x);
  sample.velocity_y = static_cast<float>(y * sample.velocity_y);
  sample.frame_width = frame.frame_width;
  sample.frame_height = frame.frame_height;
  sample.pixel_aspect_n = frame.pixel_aspect_n;
  sample.pixel_aspect_d = frame.pixel_aspect_d;
}

// Returns the motion at `place`, in the pixels of the motion's sample, which are those of the
// newest frame. Where the cells of a field are silent the confidence is 0: nothing was measured
// there.
MotionSample motion_at(const TimedMotion &motion, const PointerPosition &place) noexcept {
  if (!motion.field)
    return motion.sample;
  MotionSample sample = sample_field(*motion.field, place);
  rescale(sample, motion.sample);
  return sample;
}

bool is_measured(const TimedMotion &motion, const MotionSample &there) noexcept {
  return motion.measured && (!motion.field || there.confidence > 0);
}

bool is_taken(const HeldPlace &thing) noexcept {
  return thing.state == HoldState::held || thing.state == HoldState::hidden;
}

// Returns the way half an interval before `here`, as it goes on after it.
WayPoint way_before(const HeldPlace &here, const TimedMotion &next) noexcept {
  const double half = seconds(interval_of(next.sample)) / 2;
  const FramePoint &speed = next.way.speed;
  return {{here.x - half * speed.x, here.y - half * speed.y}, speed};
}

float between(float from, float to, double share) noexcept {
  return from + static_cast<float>((to - from) * share);
}

} // namespace

void MotionInterpolator::clear() noexcept {
  for (; count_ > 0; --count_)
    pending(count_ - 1) = {};
  first_ = 0;
  from_ = {};
  now_.measured = now_.cut = false;
  now_.sample.confidence = 0;
  now_.held = {};
  path_.end();
  newest_held_ = {};
  begun_ = cut_ = false;
  hold_.lose();
}

void MotionInterpolator::pop_front(double z) noexcept {
  from_ = std::move(pending_[first_]);
  first_ = (first_ + 1) % kCapacity;
  --count_;
  cut_ = cut_ || (from_.sample.flags & kMotionCut) != 0;
  if (!hold_.is_pressed())
    return;
  if (from_.field)
    hold_.step(*from_.field, z, from_.stretch);
  else if ((from_.sample.flags & (kMotionCut | kMotionDiscontinuity)) != 0)
    hold_.lose();
}

MotionSample MotionInterpolator::motion_from(const PointerPosition &place) const noexcept {
  if (!from_.field || !hold_.is_pressed())
    return motion_at(from_, place);
  MotionSample sample = hold_.sample();
  rescale(sample, from_.sample);
  return sample;
}

MotionSample MotionInterpolator::motion_to(const TimedMotion &motion,
                                           const PointerPosition &place) const noexcept {
  if (!motion.field || !hold_.is_pressed())
    return motion_at(motion, place);
  FieldHold hold = hold_;
  hold.step(*motion.field, place.z, motion.stretch);
  MotionSample sample = hold.sample();
  rescale(sample, motion.sample);
  return sample;
}

// Keeps everything in the pixels of the newest frame, so that a line may join frames of different
// sizes.
void MotionInterpolator::rescale_all_to(const MotionSample &sample) noexcept {
  rescale(from_.sample, sample);
  rescale(now_.sample, sample);
  for (std::size_t i = 0; i < count_; ++i)
    rescale(pending(i).sample, sample);
}

void MotionInterpolator::add(TimedMotion knot, std::int64_t now) noexcept {
  const std::int64_t interval = interval_of(knot.sample);
  const bool timed = knot.time != kAtOnce && knot.time <= now + kFarthest;
  known_until_ = std::max(timed ? knot.time + interval / 2 : now, now);
  if (!timed)
    knot.time = now;
  knot.way = middle_of_way(newest_held_, knot.sample.held, interval);
  newest_held_ = knot.sample.held;
  knot.order = ++order_;
  if (!is_taken(knot.sample.held))
    let_go_ = knot.order;

  const bool leads_on =
      knot.measured && (count_ > 0 ? pending(count_ - 1).measured : from_.measured);
  knot.time = std::max(knot.time, leads_on ? now + interval : now);
  if (knot.measured) {
    rescale_all_to(knot.sample);
    now_.interval = static_cast<double>(interval) / 1e9;
  }
  const std::int64_t closest = knot.measured ? interval / kClosestInIntervals : 0;
  bool replaces = false;
  for (; count_ > 0 && pending(count_ - 1).time > knot.time - closest; --count_) {
    // A scene that ends with what is replaced has ended all the same.
    const std::uint16_t ends =
        pending(count_ - 1).sample.flags & (kMotionCut | kMotionDiscontinuity);
    knot.sample.flags |= ends;
    if (knot.field)
      knot.field->flags |= ends;
    pending(count_ - 1) = {};
    replaces = true;
  }
  if (replaces && now_.measured) { // the line to what is replaced ends here
    from_ = {.sample = now_.sample, .measured = true, .time = now, .order = from_.order};
    if (hold_.is_pressed())
      from_.sample.held = {}; // the thing of a field has no way
  }
  if (count_ == kCapacity)
    pop_front(0);
  pending(count_++) = std::move(knot);
  begun_ = true;
}

const MotionAt &MotionInterpolator::at(std::int64_t now, const PointerPosition &place) noexcept {
  while (count_ > 0 && (pending(0).time <= now || pending(0).time > now + kFarthest))
    pop_front(place.z);
  now_.cut = std::exchange(cut_, false);
  if (count_ == 0 || from_.time > now)
    from_.time = now; // the next line begins here
  follow_thing(now);

  if (!place.pressed)
    hold_.release();
  else if (from_.field && !hold_.is_pressed())
    hold_.press(place, *from_.field);
  const MotionSample from = motion_from(place);
  now_.measured = is_measured(from_, from);
  if (now_.measured) {
    now_.sample = from;
    if (count_ > 0)
      interpolate_to_next(now, place);
  } else {
    now_.sample.confidence = 0;
  }
  if (from_.field || hold_.is_pressed())
    now_.sample.held = hold_.sample().held;
  now_.age = begun_ ? static_cast<double>(std::max<std::int64_t>(now - known_until_, 0)) * 1e-9 : 0;
  return now_;
}

// While the thing is hidden, its place is a guess, to which nothing leads.
void MotionInterpolator::follow_thing(std::int64_t now) noexcept {
  const HeldPlace &here = from_.sample.held;
  const TimedMotion *next = count_ > 0 ? &pending(0) : nullptr;
  const bool let_go = from_.order < let_go_;
  now_.held = {.state = let_go ? HoldState::none : here.state};
  if (let_go || !is_taken(here))
    return path_.end();
  const bool leads_on =
      next && next->sample.held.state == HoldState::held && is_same_thing(here, next->sample.held);
  const bool another = path_.begun() && here.time < thing_since_;
  if (!path_.begun() || another)
    path_.begin(leads_on ? way_before(here, *next) : WayPoint{{here.x, here.y}, {}}, now);
  thing_since_ = here.time;
  if (leads_on)
    path_.lead_to(next->way, next->time, now);
  else if (here.state == HoldState::held)
    path_.stop_at({here.x, here.y}, interval_of(from_.sample), now);
  const HoldState state = now_.held.state;
  now_.held = path_.at(now);
  now_.held.state = state;
  now_.held.another = another;
}

void MotionInterpolator::interpolate_to_next(std::int64_t now,
                                             const PointerPosition &place) noexcept {
  const TimedMotion &next = pending(0);
  const MotionSample to = motion_to(next, place);
  if (!is_measured(next, to))
    return;
  const double share = static_cast<double>(now - from_.time) /
                       static_cast<double>(std::max<std::int64_t>(next.time - from_.time, 1));
  now_.sample.confidence = between(now_.sample.confidence, to.confidence, share);
  static_cast<PlanarMotion &>(now_.sample) = interpolated(now_.sample, to, share);
}

} // namespace haptic
