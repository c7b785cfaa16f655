// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/film-segments.hpp"

#include "forms/klv.hpp"
#include "seconds.hpp"
#include "track-error.hpp"
#include "tracks/field-track.hpp"

#include <algorithm>
#include <iterator>
#include <optional>

namespace haptic {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kShortest = 2 * kSecond;
constexpr std::int64_t kWanted = 4 * kSecond;
constexpr std::int64_t kLongest = 6 * kSecond;
// The frames of a segment are in memory.
constexpr std::int64_t kMost = 60 * kSecond;
constexpr std::int64_t kFrame = kSecond / 25; // of a film of one frame

struct PlannedFrame {
  std::int64_t time = 0;
  bool is_idr = false;
};

// IDR frames are presented after all before them: the times of a group are those of its frames in
// order. Throws if they are not.
void sort_groups(const std::string &path, std::vector<PlannedFrame> &frames, FilmPlan &plan) {
  for (auto group = frames.begin(); group != frames.end();) {
    const auto next =
        std::find_if(group + 1, frames.end(), [](const PlannedFrame &f) { return f.is_idr; });
    std::vector<std::int64_t> times;
    std::transform(group, next, std::back_inserter(times), [](const auto &f) { return f.time; });
    std::ranges::sort(times);
    for (std::size_t i = 0; i < times.size(); ++i) {
      plan.reordering =
          std::max(plan.reordering, times[i] - group[static_cast<std::ptrdiff_t>(i)].time);
      if (!plan.times.empty() && ticks_of(times[i]) <= ticks_of(plan.times.back()))
        throw_error(messages::kFilmRunsBackwards, path.c_str(), seconds(times[i] - plan.origin));
      plan.times.push_back(times[i]);
    }
    group = next;
  }
  for (std::int64_t &time : plan.times)
    time -= plan.origin;
}

// Begins a segment at the first IDR frame after the wanted length, or before where that would be
// too long.
void choose_starts(const std::vector<PlannedFrame> &frames, FilmPlan &plan) {
  plan.starts = {0};
  std::int64_t last = 0; // IDR frame within the segment, 0: none
  std::size_t last_index = 0;
  for (std::size_t i = 1; i <= frames.size(); ++i) {
    if (i < frames.size() && !frames[i].is_idr)
      continue;
    const std::int64_t time = i < frames.size() ? plan.times[i] : plan.end;
    const std::int64_t start = plan.times[plan.starts.back()];
    if (time - start > kLongest && last - start >= kShortest)
      plan.starts.push_back(last_index);
    if (i < frames.size() && time - plan.times[plan.starts.back()] >= kWanted)
      plan.starts.push_back(i);
    last = time;
    last_index = i;
  }
  // The rest of the film may be short.
  const std::size_t count = plan.starts.size();
  if (count > 1 && plan.end - plan.start_of(count - 1) < kShortest &&
      plan.end - plan.start_of(count - 2) <= kLongest)
    plan.starts.pop_back();
  for (std::size_t i = 0; i < plan.starts.size(); ++i)
    plan.longest = std::max(plan.longest, plan.start_of(i + 1) - plan.start_of(i));
}

// Returns the presentation of the frame of the same time as the field.
std::int64_t frame_at(const FilmPlan &plan, std::int64_t time) {
  const auto after = std::ranges::lower_bound(plan.times, time - kSameTime);
  return after != plan.times.end() && *after <= time + kSameTime ? *after : time;
}

// Returns the fields and reliefs with times of this film's frames, and key fields at each start.
std::vector<CodedField> track_of(const FilmPlan &plan, std::span<const CodedField> track) {
  std::vector<CodedField> fields;
  for (const CodedField &coded : track)
    fields.push_back(
        {coded.bytes,
         static_cast<std::uint64_t>(frame_at(plan, static_cast<std::int64_t>(coded.time))),
         coded.duration, coded.kind, coded.things});
  std::vector<std::uint64_t> starts;
  starts.reserve(plan.starts.size());
  for (std::size_t i = 0; i < plan.starts.size(); ++i)
    starts.push_back(static_cast<std::uint64_t>(plan.start_of(i)));
  return with_keys_at(fields, starts);
}

// Collects the frames of the segments.
class Collector {
public:
  Collector(const FilmPlan &plan, std::span<const CodedField> track,
            const std::function<void(const FilmSegment &)> &call)
      : plan_(plan), fields_(track_of(plan, track)), call_(call) {}

  void push_video(FilmFrame &&frame) {
    if (skipped_ < plan_.skipped) {
      ++skipped_;
      return;
    }
    const std::size_t i = count_++;
    if (i >= plan_.times.size())
      return; // of a file that grows
    const std::int64_t next = i + 1 < plan_.times.size() ? plan_.times[i + 1] : plan_.end;
    frames_.push_back({ticks_of(frame.time - plan_.origin), ticks_of(plan_.times[i]),
                       ticks_of(next) - ticks_of(plan_.times[i]), frame.is_idr,
                       std::move(frame.bytes)});
  }

  void push_sound(FilmFrame &&frame) {
    const std::int64_t time = frame.time - plan_.origin;
    heard_ = std::max(heard_, time);
    if (time >= 0 && time < plan_.end)
      sounds_.push_back({time, std::move(frame.bytes)});
  }

  // Finishes the segments that are complete.
  void finish(bool over) {
    while (number_ < plan_.starts.size()) {
      const std::int64_t end = plan_.start_of(number_ + 1);
      const std::size_t last =
          number_ + 1 < plan_.starts.size() ? plan_.starts[number_ + 1] : plan_.times.size();
      const bool is_heard = heard_ >= std::min(end, plan_.last_sound);
      if (!over && (count_ < last || !is_heard))
        return;
      finish_segment(last - plan_.starts[number_], end);
    }
  }

private:
  void finish_segment(std::size_t count, std::int64_t end) {
    FilmSegment segment{number_, plan_.start_of(number_), end, {}, {}, {}};
    const bool is_last = ++number_ == plan_.starts.size();
    const auto last =
        frames_.begin() + static_cast<std::ptrdiff_t>(std::min(count, frames_.size()));
    std::move(frames_.begin(), last, std::back_inserter(segment.frames));
    frames_.erase(frames_.begin(), last);
    const auto heard = std::ranges::find_if(
        sounds_, [&](const SegmentSound &sound) { return !is_last && sound.time >= end; });
    std::move(sounds_.begin(), heard, std::back_inserter(segment.sounds));
    sounds_.erase(sounds_.begin(), heard);
    for (; field_ < fields_.size(); ++field_) {
      const CodedField &field = fields_[field_];
      const auto time = static_cast<std::int64_t>(field.time);
      if (!is_last && time >= end)
        break;
      segment.fields.push_back({ticks_of(time), field.kind, write_klv(field)});
    }
    call_(segment);
  }

  const FilmPlan &plan_;
  std::vector<CodedField> fields_;
  const std::function<void(const FilmSegment &)> &call_;
  std::size_t number_ = 0; // of the segment
  std::size_t skipped_ = 0;
  std::size_t count_ = 0; // of frames that were read
  std::size_t field_ = 0; // the next one
  std::int64_t heard_ = -1;
  std::vector<SegmentFrame> frames_;
  std::vector<SegmentSound> sounds_;
};

} // namespace

FilmPlan plan_film(const std::string &path) {
  FilmPlan plan;
  std::vector<PlannedFrame> frames;
  std::optional<std::int64_t> last_sound;
  plan.format = read_film(path, [&](const FilmFrame &frame) {
    if (frame.is_sound)
      last_sound = std::max(frame.time, last_sound.value_or(frame.time));
    else if (frames.empty() && !frame.is_idr)
      ++plan.skipped;
    else
      frames.push_back({frame.time, frame.is_idr});
  });
  if (frames.empty())
    throw_error(messages::kFilmHasNoStart, path.c_str());
  plan.origin = frames.front().time;
  plan.last_sound = last_sound ? std::max<std::int64_t>(*last_sound - plan.origin, -1) : -1;
  sort_groups(path, frames, plan);
  const std::size_t count = plan.times.size();
  plan.end = plan.times.back() + (count > 1 ? plan.times.back() - plan.times[count - 2] : kFrame);
  choose_starts(frames, plan);
  if (plan.longest > kMost)
    throw_error(messages::kFilmIsNotCut, path.c_str(), seconds(plan.longest));
  return plan;
}

void for_each_segment(const std::string &path, const FilmPlan &plan,
                      std::span<const CodedField> track,
                      const std::function<void(const FilmSegment &)> &call) {
  Collector collector(plan, track, call);
  read_film(path, [&](FilmFrame &&frame) {
    if (frame.is_sound)
      collector.push_sound(std::move(frame));
    else
      collector.push_video(std::move(frame));
    collector.finish(false);
  });
  collector.finish(true);
}

} // namespace haptic
