// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/stream-track.hpp"

#include <utility>

namespace haptic {

void StreamTrack::push(const InputPacket &packet) {
  std::vector<TrackItem> items;
  form_->read(packet, items);
  for (TrackItem &item : items)
    if (const auto *problem = std::get_if<TrackProblem>(&item)) {
      report(*problem);
    } else if (const auto *sample = std::get_if<TimedSample>(&item)) {
      track_.samples.push_back(sample->sample);
      place(false, sample->time);
    } else if (auto *field = std::get_if<TimedField>(&item)) {
      track_.fields.push_back(std::move(field->field));
      place(true, field->time);
    }
}

void StreamTrack::report(const TrackProblem &problem) {
  if (const char *sentence = problems_.first_warning(problem.kind))
    track_.remarks.push_back({problem.kind, sentence});
}

// Of the last sample or field. Its time is the sender's.
void StreamTrack::place(bool is_field, std::uint64_t pts) {
  std::uint64_t &time = is_field ? track_.fields.back().time : track_.samples.back().time;
  const std::uint64_t duration =
      is_field ? track_.fields.back().duration : track_.samples.back().duration;
  const std::uint64_t sent = time;
  if (pts == kNoTime && sent != kNoTime) {
    if (!clock_.is_tied()) {
      untied_.push_back({is_field, (is_field ? track_.fields.size() : track_.samples.size()) - 1});
      return;
    }
    pts = clock_.recovered(sent, 0);
    report({TrackProblemKind::without_time, {}});
  }
  time = pts;
  tie(pts, sent, duration);
}

// Gives those before the first time stamp their times. One that would be before 0 has none.
void StreamTrack::tie(std::uint64_t pts, std::uint64_t sent, std::uint64_t duration) {
  if (pts == kNoTime)
    return;
  for (const auto &[is_field, index] : std::exchange(untied_, {})) {
    std::uint64_t &time = is_field ? track_.fields[index].time : track_.samples[index].time;
    const bool is_near =
        sent != kNoTime && time <= sent && sent - time <= pts && sent - time <= kLargestTimeStep;
    time = is_near ? pts - (sent - time) : kNoTime;
  }
  clock_.remember(pts, sent, duration);
}

void StreamTrack::finish() {
  if (untied_.empty())
    return;
  report({TrackProblemKind::untied, {}});
  for (const auto &[is_field, index] : std::exchange(untied_, {})) {
    std::uint64_t &time = is_field ? track_.fields[index].time : track_.samples[index].time;
    const std::uint64_t sent = time;
    time = clock_.recovered(sent, 0);
    clock_.remember(time, sent, kNoTime);
  }
}

} // namespace haptic
