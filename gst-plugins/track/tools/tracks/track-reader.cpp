// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/track-reader.hpp"

#include <utility>

namespace haptic {
namespace {

constexpr std::size_t kNamed = 5; // damaged packets

} // namespace

void TrackReader::push(const InputPacket &packet, std::size_t at) {
  std::vector<TrackItem> items;
  form_->read(packet, items);
  take(items, at);
}

void TrackReader::take(std::vector<TrackItem> &items, std::size_t at) {
  for (TrackItem &item : items)
    if (const auto *problem = std::get_if<TrackProblem>(&item)) {
      report(*problem, at);
    } else if (const auto *sample = std::get_if<TimedSample>(&item)) {
      track_.samples.push_back(sample->sample);
      place({false, track_.samples.size() - 1}, sample->time, sample->sample.duration);
    } else if (auto *field = std::get_if<TimedField>(&item)) {
      track_.fields.push_back(std::move(field->field));
      place({true, track_.fields.size() - 1}, field->time, track_.fields.back().duration);
    }
}

void TrackReader::report(const TrackProblem &problem, std::size_t at) {
  if (!damaged_) {
    track_.is_untied = track_.is_untied || problem.kind == TrackProblemKind::untied;
    if (const char *sentence = problems_.first_warning(problem.kind))
      track_.remarks.emplace_back(sentence);
  } else if (problem.kind == TrackProblemKind::unsupported) {
    track_.remarks.push_back("left out: " + problem.details);
  } else if (problem.kind != TrackProblemKind::damaged &&
             problem.kind != TrackProblemKind::foreign_text) {
    ++others_;
  } else if (++damage_ <= kNamed) {
    const std::string place = *damaged_ ? damaged_ + std::to_string(at) : "damaged";
    track_.remarks.push_back(place + ": " + problem.details);
  }
}

std::uint64_t &TrackReader::time_of(const Taken &one) {
  return one.is_field ? track_.fields[one.index].time : track_.samples[one.index].time;
}

// The sample has the sender's time until it gets its own.
void TrackReader::place(const Taken &one, std::uint64_t pts, std::uint64_t duration) {
  const std::uint64_t sent = time_of(one);
  if (pts == kNoTime && sent != kNoTime) {
    if (damaged_)
      return;
    if (!clock_.is_tied()) {
      untied_.push_back(one);
      return;
    }
    pts = clock_.recovered(sent, 0);
    report({TrackProblemKind::without_time, {}}, 0);
  }
  time_of(one) = pts;
  tie(pts, sent, duration);
}

// Gives those before the first time stamp their times. One that would be before 0 has none.
void TrackReader::tie(std::uint64_t pts, std::uint64_t sent, std::uint64_t duration) {
  if (pts == kNoTime)
    return;
  for (const Taken &one : std::exchange(untied_, {})) {
    std::uint64_t &time = time_of(one);
    const bool is_near =
        sent != kNoTime && time <= sent && sent - time <= pts && sent - time <= kLargestTimeStep;
    time = is_near ? pts - (sent - time) : kNoTime;
  }
  clock_.remember(pts, sent, duration);
}

void TrackReader::finish(std::size_t at) {
  std::vector<TrackItem> items;
  form_->finish_reading(items);
  take(items, at);
  if (damage_ > kNamed)
    track_.remarks.push_back(format_text("%zu further ones were left out", damage_ - kNamed));
  if (others_ > 0)
    track_.remarks.push_back(
        format_text("%zu sets of other origin, version or kind were passed over", others_));
  if (!untied_.empty())
    report({TrackProblemKind::untied, {}}, 0);
  for (const Taken &one : std::exchange(untied_, {})) {
    const std::uint64_t sent = time_of(one);
    time_of(one) = clock_.recovered(sent, 0);
    clock_.remember(time_of(one), sent, kNoTime);
  }
}

} // namespace haptic
