// SPDX-License-Identifier: LGPL-2.1-or-later
#include "touch/relief-timeline.hpp"

#include "samples/motion-sample.hpp"
#include "seconds.hpp"

#include <algorithm>
#include <utility>

namespace haptic {
namespace {

constexpr std::int64_t kUsualInterval = 33'333'333;  // ns, of a relief that has none
constexpr std::int64_t kLongestLine = 2'000'000'000; // ns

std::int64_t interval_of(const ReliefField &relief) noexcept {
  const auto interval = static_cast<std::int64_t>(
      std::min<std::uint64_t>(relief.interval, static_cast<std::uint64_t>(kLongestLine)));
  return interval > 0 ? interval : kUsualInterval;
}

} // namespace

void ReliefTimeline::add(TimedRelief relief, std::int64_t now) noexcept {
  if (count_ == kCapacity) { // of a source that does not wait: the oldest is lost
    first_ = (first_ + 1) % kCapacity;
    --count_;
  }
  pending_[(first_ + count_) % kCapacity] = {std::move(relief), now};
  ++count_;
}

void ReliefTimeline::clear() noexcept {
  for (Pending &pending : pending_)
    pending = {};
  first_ = count_ = 0;
  from_ = {};
  to_ = {};
  now_ = {};
}

std::int64_t ReliefTimeline::due_at(const Pending &pending) noexcept {
  return pending.relief.time == kAtOnce ? pending.arrival : pending.relief.time;
}

// Returns whether the next relief was made the end of a line, or stands.
bool ReliefTimeline::begin_next(std::int64_t now) noexcept {
  if (count_ == 0)
    return false;
  Pending &next = pending_[first_];
  TimedRelief &relief = next.relief;
  const bool line = relief.field && to_ && !(relief.field->flags & kMotionCut);
  const std::int64_t due = due_at(next);
  if (!line && due > now)
    return false;
  newest_ = std::max(due, next.arrival);
  begin_ = line ? std::max(std::min(end_, now), next.arrival) : std::max(due, next.arrival);
  end_ = begin_;
  if (line)
    end_ = due > begin_ ? due : begin_ + interval_of(*relief.field);
  now_.cut |= relief.field && to_ && !line;
  from_ = line ? std::move(to_) : ReliefPool::Field{};
  to_ = std::move(relief.field);
  first_ = (first_ + 1) % kCapacity;
  --count_;
  return true;
}

const ReliefAt &ReliefTimeline::at(std::int64_t now) noexcept {
  now_.cut = false;
  // A source that is faster than its intervals: lines are cut short rather than queue.
  const auto is_behind = [&] {
    return count_ > 1 && due_at(pending_[(first_ + 1) % kCapacity]) <= now;
  };
  while ((now >= end_ || !to_ || is_behind()) && begin_next(now)) {
  }
  now_.to = to_.get();
  now_.from = from_ ? from_.get() : now_.to;
  if (!to_)
    return now_;
  now_.weight =
      end_ > begin_ ? std::clamp(seconds(now - begin_) / seconds(end_ - begin_), 0.0, 1.0) : 1.0;
  now_.age = std::max(0.0, seconds(now - newest_));
  now_.interval = seconds(interval_of(*to_));
  return now_;
}

} // namespace haptic
