#include "motion-interpolator.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000; // ns
constexpr std::int64_t kLongestRamp = kSecond;  // ns
constexpr std::int64_t kFarthest = 3 * kSecond; // ns; what is due later has a wrong time
constexpr std::int64_t kClosestInIntervals = 4; // closer ones would make a step between them

std::int64_t interval_of(const MotionSample &sample) noexcept {
  return static_cast<std::int64_t>(std::min<std::uint64_t>(sample.interval, kLongestRamp));
}

void rescale(MotionSample &sample, const MotionSample &picture) noexcept {
  const bool same = sample.picture_width == picture.picture_width &&
                    sample.pixel_aspect_n == picture.pixel_aspect_n &&
                    sample.pixel_aspect_d == picture.pixel_aspect_d;
  if (same || sample.picture_width == 0)
    return;
  const double x = static_cast<double>(picture.picture_width) / sample.picture_width;
  const double y = x * sample.pixel_aspect_d / sample.pixel_aspect_n * picture.pixel_aspect_n /
                   picture.pixel_aspect_d;
  sample.velocity_x = static_cast<float>(x * sample.velocity_x);
  sample.velocity_y = static_cast<float>(y * sample.velocity_y);
  sample.picture_width = picture.picture_width;
  sample.picture_height = picture.picture_height;
  sample.pixel_aspect_n = picture.pixel_aspect_n;
  sample.pixel_aspect_d = picture.pixel_aspect_d;
}

float between(float from, float to, double share) noexcept {
  return from + static_cast<float>((to - from) * share);
}

} // namespace

void MotionInterpolator::clear() noexcept {
  first_ = count_ = 0;
  from_ = {};
  now_.measured = now_.cut = false;
  now_.sample.confidence = 0;
  begun_ = false;
}

void MotionInterpolator::pop_front() noexcept {
  from_ = pending_[first_];
  first_ = (first_ + 1) % kCapacity;
  --count_;
}

// Everything is kept in the pixels of the newest picture, so that lines between pictures of
// different sizes are meaningful.
void MotionInterpolator::take_picture_of(const MotionSample &sample) noexcept {
  rescale(from_.sample, sample);
  rescale(now_.sample, sample);
  for (std::size_t i = 0; i < count_; ++i)
    rescale(pending(i).sample, sample);
}

void MotionInterpolator::add(const TimedMotion &motion, std::int64_t now) noexcept {
  const std::int64_t interval = interval_of(motion.sample);
  TimedMotion knot = motion;
  const bool timed = motion.time != kAtOnce && motion.time <= now + kFarthest;
  if (!timed)
    knot.time = now;
  known_until_ = std::max(timed ? motion.time + interval / 2 : now, now);

  const bool leads_on =
      knot.measured && (count_ > 0 ? pending(count_ - 1).measured : from_.measured);
  knot.time = std::max(knot.time, leads_on ? now + interval : now);
  if (knot.measured) {
    take_picture_of(knot.sample);
    now_.interval = static_cast<double>(interval) / static_cast<double>(kSecond);
  }
  const std::int64_t closest = knot.measured ? interval / kClosestInIntervals : 0;
  bool replaces = false;
  for (; count_ > 0 && pending(count_ - 1).time > knot.time - closest; --count_)
    replaces = true;
  if (replaces && now_.measured) { // the line to what is replaced ends where it has come to
    from_.sample = now_.sample;
    from_.time = now;
  }
  if (count_ == kCapacity)
    pop_front();
  pending(count_++) = knot;
  begun_ = true;
}

const MotionAt &MotionInterpolator::at(std::int64_t now) noexcept {
  now_.cut = false;
  while (count_ > 0 && (pending(0).time <= now || pending(0).time > now + kFarthest)) {
    pop_front();
    now_.cut = now_.cut || (from_.sample.flags & kMotionCut) != 0;
  }
  if (count_ == 0 || from_.time > now)
    from_.time = now; // a line to what comes next will begin where this one has come to

  now_.measured = from_.measured;
  if (from_.measured) {
    now_.sample = from_.sample;
    if (count_ > 0 && pending(0).measured) {
      const TimedMotion &to = pending(0);
      const double share = static_cast<double>(now - from_.time) /
                           static_cast<double>(std::max<std::int64_t>(to.time - from_.time, 1));
      MotionSample &s = now_.sample;
      s.velocity_x = between(s.velocity_x, to.sample.velocity_x, share);
      s.velocity_y = between(s.velocity_y, to.sample.velocity_y, share);
      s.spin = between(s.spin, to.sample.spin, share);
      s.divergence = between(s.divergence, to.sample.divergence, share);
      s.confidence = between(s.confidence, to.sample.confidence, share);
    }
  } else {
    now_.sample.confidence = 0;
  }
  now_.age = begun_ ? static_cast<double>(std::max<std::int64_t>(now - known_until_, 0)) * 1e-9 : 0;
  return now_;
}

} // namespace haptic
