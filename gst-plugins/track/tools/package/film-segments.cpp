// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/film-segments.hpp"

#include "forms/klv.hpp"
#include "seconds.hpp"
#include "track-error.hpp"
#include "tracks/field-track.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

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
void sort_groups(const std::string &path, const std::vector<PlannedFrame> &frames, FilmPlan &plan) {
  for (auto frame = frames.begin(); frame != frames.end();) {
    std::vector<PlannedFrame> group(
        frame, std::ranges::find(frame + 1, frames.end(), true, &PlannedFrame::is_idr));
    std::ranges::sort(group, {}, &PlannedFrame::time);
    for (const PlannedFrame &turn : group) {
      const std::int64_t time = turn.time - plan.origin;
      plan.reordering = std::max(plan.reordering, turn.time - (frame++)->time);
      if (!plan.times.empty() && ticks_of(time) <= ticks_of(plan.times.back()))
        throw_error(messages::kFilmRunsBackwards, path.c_str(), seconds(time));
      plan.times.push_back(time);
    }
  }
}

// Begins a segment at the first IDR frame after the wanted length, or before where that would be
// too long.
void choose_starts(const std::vector<PlannedFrame> &frames, FilmPlan &plan) {
  plan.starts = {plan.times[0]};
  std::int64_t last = plan.times[0]; // IDR frame within the segment
  for (std::size_t i = 1; i <= frames.size(); ++i) {
    if (i < frames.size() && !frames[i].is_idr)
      continue;
    const std::int64_t time = i < frames.size() ? plan.times[i] : plan.end;
    if (time - plan.starts.back() > kLongest && last - plan.starts.back() >= kShortest)
      plan.starts.push_back(last);
    if (i < frames.size() && time - plan.starts.back() >= kWanted)
      plan.starts.push_back(time);
    last = time;
  }
  // The rest of the film may be short.
  const std::size_t count = plan.starts.size();
  if (count > 1 && plan.end - plan.start_of(count - 1) < kShortest &&
      plan.end - plan.start_of(count - 2) <= kLongest)
    plan.starts.pop_back();
  for (std::size_t i = 0; i < plan.starts.size(); ++i)
    plan.longest = std::max(plan.longest, plan.start_of(i + 1) - plan.start_of(i));
}

// Returns the segment that holds a time, but none before the one with the number `first`.
FilmSegment &segment_at(std::vector<FilmSegment> &segments, std::size_t first, std::int64_t time) {
  const auto begin =
      segments.begin() + static_cast<std::ptrdiff_t>(std::min(first + 1, segments.size()));
  return *std::prev(std::ranges::upper_bound(begin, segments.end(), time, {}, &FilmSegment::start));
}

// Returns the segments with their fields, which get the times of this film's frames. The first
// field of each segment is a key field.
std::vector<FilmSegment> segments_of(const FilmPlan &plan, std::span<const CodedField> track) {
  std::vector<FilmSegment> segments;
  std::vector<std::uint64_t> starts;
  for (std::size_t i = 0; i < plan.starts.size(); ++i) {
    segments.push_back({i, plan.start_of(i), plan.start_of(i + 1), {}, {}, {}});
    starts.push_back(static_cast<std::uint64_t>(plan.start_of(i)));
  }
  std::vector<CodedField> fields(track.begin(), track.end());
  for (CodedField &field : fields) {
    const auto time = static_cast<std::int64_t>(field.time);
    const auto frame = std::ranges::lower_bound(plan.times, time - kSameTime);
    if (frame != plan.times.end() && *frame <= time + kSameTime)
      field.time = static_cast<std::uint64_t>(*frame);
  }
  fields = with_keys_at(fields, starts);
  for (const CodedField &field : fields) {
    const auto time = static_cast<std::int64_t>(field.time);
    segment_at(segments, 0, time).fields.push_back({ticks_of(time), field.kind, write_klv(field)});
  }
  return segments;
}

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
  std::vector<FilmSegment> segments = segments_of(plan, track); // empty after their call
  std::size_t next = 0;                                         // the first that is not complete
  std::size_t count = 0;                                        // of frames that were read
  std::int64_t heard = -1;
  const auto finish = [&](bool over) {
    while (next < segments.size()) {
      const std::int64_t end = segments[next].end;
      const bool is_seen = count == plan.times.size() || plan.times[count] >= end;
      if (!over && (!is_seen || heard < std::min(end, plan.last_sound)))
        return;
      call(std::exchange(segments[next++], {}));
    }
  };
  read_film(path, [&](FilmFrame &&frame) {
    const std::int64_t time = frame.time - plan.origin;
    if (frame.is_sound) {
      heard = std::max(heard, time);
      if (time >= 0 && time < plan.end)
        segment_at(segments, next, time).sounds.push_back({time, std::move(frame.bytes)});
    } else if ((count > 0 || frame.is_idr) && count < plan.times.size()) { // a file may grow
      const std::int64_t turn = plan.times[count++];
      const std::int64_t after = count < plan.times.size() ? plan.times[count] : plan.end;
      segment_at(segments, next, turn)
          .frames.push_back({ticks_of(time), ticks_of(turn), ticks_of(after) - ticks_of(turn),
                             frame.is_idr, std::move(frame.bytes)});
    }
    finish(false);
  });
  finish(true);
}

} // namespace haptic
