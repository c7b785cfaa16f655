// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/track-reader.hpp"

#include <algorithm>
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
    if (const auto *problem = std::get_if<TrackProblem>(&item))
      report(*problem, at);
    else if (auto *sample = std::get_if<TimedSample>(&item))
      place(sample->sample, sample->time, track_.samples);
    else if (auto *field = std::get_if<TimedField>(&item))
      place(field->field, field->time,
            field->field.kind == FieldKind::relief ? track_.reliefs : track_.fields);
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

// All have the sender's time until the first time stamp. Then one that would be before 0 has none.
template <typename Timed>
void TrackReader::place(Timed &one, std::uint64_t pts, std::vector<Timed> &all) {
  const std::uint64_t sent = one.time;
  if (pts == kNoTime && sent != kNoTime && clock_.is_tied()) {
    pts = clock_.recovered(sent, 0);
    report({TrackProblemKind::without_time, {}}, 0);
  }
  if (pts != kNoTime && !clock_.is_tied())
    track_.for_each([&](auto &early) {
      const std::uint64_t by = sent - early.time;
      const bool is_near =
          sent != kNoTime && early.time <= sent && by <= std::min(pts, kLargestTimeStep);
      early.time = is_near ? pts - by : kNoTime;
    });
  if (pts != kNoTime && sent != kNoTime && !sender_ahead_)
    sender_ahead_ = sent - pts;
  if (pts != kNoTime)
    one.time = pts;
  clock_.remember(pts, sent, one.duration);
  all.push_back(std::move(one));
}

void TrackReader::take_times_of_sender() noexcept {
  const std::uint64_t by = sender_ahead_.value_or(0);
  track_.for_each([by](auto &one) { one.time += one.time == kNoTime ? 0 : by; });
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
  if (damaged_ || clock_.is_tied())
    return;
  std::uint64_t begin = kNoTime; // the sender's, of the first one: it may have been started anew
  const auto begin_with = [&](const auto &all) {
    begin = std::min(begin, all.empty() ? kNoTime : all.front().time);
  };
  begin_with(track_.samples);
  begin_with(track_.fields);
  begin_with(track_.reliefs);
  if (begin == kNoTime)
    return;
  report({TrackProblemKind::untied, {}}, 0);
  const auto place_all = [&](auto &all) {
    clock_.remember(0, begin, kNoTime);
    for (auto &one : all)
      if (const std::uint64_t sent = one.time; sent != kNoTime) {
        one.time = clock_.recovered(sent, 0);
        clock_.remember(one.time, sent, kNoTime);
      }
  };
  place_all(track_.samples);
  place_all(track_.fields);
  place_all(track_.reliefs);
}

} // namespace haptic
