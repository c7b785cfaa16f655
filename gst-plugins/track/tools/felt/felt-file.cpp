// SPDX-License-Identifier: LGPL-2.1-or-later
#include "felt/felt-file.hpp"

#include "samples/field-sampler.hpp"
#include "samples/region-size.hpp"
#include "seconds.hpp"
#include "tracks/field-track.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kLongest = 4 * 3600 + 1; // s

// Keeps the times rising.
template <typename Timed>
void append(std::vector<Timed> &all, const Timed &one) {
  if (all.empty() || one.time > all.back().time)
    all.push_back(one);
}

FeltMotion felt_at(const MotionField &field, const PointerPosition &hand, std::uint64_t time) {
  return felt_motion(sample_field(field, hand), time);
}
FeltSurface felt_at(const ReliefField &relief, const PointerPosition &hand, std::uint64_t time) {
  return felt_surface(relief, hand.x, hand.y, time);
}

// Calls `call(i, felt, hand, field)` for what hand i feels of each field or relief. Between two of
// them, a hand on a path feels both where it is at each time.
template <typename Field, typename ForEach, typename Call>
void feel_each(const ForEach &for_each, std::span<const CodedField> track, const Hands &hands,
               const Call &call) {
  Field before;
  std::uint64_t time_before = kNoTime;
  for_each(track, [&](const Field &field, std::uint64_t time) {
    for (std::size_t i = 0; i < hands.resting.size(); ++i)
      call(i, felt_at(field, hands.resting[i], time), hands.resting[i], field);
    if (!hands.path.empty()) {
      const double end = felt_at(field, {}, time).time;
      const double begin = time_before == kNoTime ? end : felt_at(before, {}, time_before).time;
      const double length = end - begin;
      for (double at = begin + kPathStep; length <= kLongestMotionGap && at < end - kPathStep / 2;
           at += kPathStep) {
        const PointerPosition hand = place_at(hands.path, at);
        call(0,
             interpolated(felt_at(before, hand, time_before), felt_at(field, hand, time),
                          (at - begin) / length),
             hand, field);
      }
      const PointerPosition hand = place_at(hands.path, end);
      call(0, felt_at(field, hand, time), hand, field);
    }
    before = field;
    time_before = time;
  });
  if (time_before == kNoTime)
    throw_error(messages::kNoFieldIsDecoded);
}

template <typename Timed>
void add_to_times(std::vector<Timed> &all, double offset) {
  for (Timed &one : all)
    one.time += offset;
}

} // namespace

FeltFile::FeltFile(const std::string &path, const std::string &stream) : path_(path) {
  if (is_force_log(path)) {
    log_ = read_force_log(path);
    return;
  }
  track_ = read_one_kind(path, stream);
}

std::optional<double> FeltFile::film_begin() const {
  return film_begin_of(track_);
}

double FeltFile::track_begin() const {
  return track_.holds_nothing() ? 0 : seconds(times_of(track_).first);
}

std::vector<TimedPlace> FeltFile::hand() const {
  std::vector<TimedPlace> path = log_.places;
  add_to_times(path, offset_);
  for (const auto &[sample, time, duration] : track_.samples) {
    const double side = static_cast<double>(sample.region_width) * sample.frame_width;
    // region_growth() inverted
    const double z =
        side > 0 ? std::log2(side / default_region_side(static_cast<int>(sample.frame_width))) / 2
                 : 0;
    const double middle = felt_motion(sample, time).time + offset_;
    append(path, TimedPlace{middle, sample.pointer_x, sample.pointer_y,
                            static_cast<float>(std::clamp(z, -1.0, 1.0))});
  }
  return path;
}

void FeltFile::feel(const Hands &hands, const ForceLaw &law, const TimeRange &range) {
  law_ = law;
  if (has_places()) {
    Hands in_own_time = hands;
    add_to_times(in_own_time.path, -offset_);
    if (has_reliefs())
      feel_reliefs(in_own_time);
    else
      feel_fields(in_own_time);
  } else if (!track_.empty()) {
    auto &motions = motions_.emplace_back();
    for (const auto &sample : track_.samples)
      append(motions, felt_motion(sample.motion, sample.time));
  }
  const auto place = [&](auto &all) {
    add_to_times(all, offset_);
    std::erase_if(all,
                  [&](const auto &one) { return one.time < range.from || one.time >= range.to; });
    if (!all.empty()) {
      begin_ = all.front().time;
      end_ = all.back().time;
    }
  };
  place(log_.forces);
  std::ranges::for_each(motions_, place);
  std::ranges::for_each(surfaces_, place);
  if (end_ < begin_)
    throw_error(messages::kNothingToCompare, path_.c_str());
  if (!(end_ - begin_ <= kLongest))
    throw_error(messages::kTooLongToCompare, path_.c_str());
}

void FeltFile::feel_fields(const Hands &hands) {
  motions_.resize(hands.count());
  feel_each<MotionField>(
      for_each_field, track_.fields, hands,
      [&](std::size_t i, const FeltMotion &motion, auto &&...) { append(motions_[i], motion); });
}

void FeltFile::feel_reliefs(const Hands &hands) {
  surfaces_.resize(hands.resting.size());
  bool has_surface = false;
  feel_each<ReliefField>(
      for_each_relief, track_.reliefs, hands,
      [&](std::size_t i, const FeltSurface &surface, const PointerPosition &hand,
          const ReliefField &relief) {
        if (hands.path.empty())
          append(surfaces_[i], surface);
        else
          append(log_.forces,
                 {surface.time, contact_force(surface, kWorkspaceHalf * hand.z, law_.max_force)});
        has_surface = has_surface || std::ranges::any_of(relief.cells, [](const ReliefCell &cell) {
                        return cell.validity > 0;
                      });
      });
  if (!has_surface)
    throw_error(messages::kNoSurface, path_.c_str());
}

ForceSignal FeltFile::signal(std::size_t hand) const {
  if (motions_.empty())
    return signal_of_log(log_.forces);
  return signal_of_motions(motions_[std::min(hand, motions_.size() - 1)], law_);
}

} // namespace haptic
