// SPDX-License-Identifier: LGPL-2.1-or-later
#include "felt/felt-file.hpp"

#include "samples/field-sampler.hpp"
#include "samples/region-size.hpp"
#include "seconds.hpp"
#include "tracks/field-track.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptic {
namespace {

constexpr double kLongest = 4 * 3600 + 1; // s

// Keeps the times rising.
template <typename Timed>
void append(std::vector<Timed> &all, const Timed &one) {
  if (all.empty() || one.time > all.back().time)
    all.push_back(one);
}

// Appends the motions under a moving hand between two fields, with the second one. The hand feels
// both fields where it is at each time.
void append_along(const std::vector<TimedPlace> &path, const MotionField &before,
                  std::uint64_t time_before, const MotionField &field, std::uint64_t time,
                  std::vector<FeltMotion> &motions) {
  const double begin = felt_motion(frame_of(before), time_before).time;
  const double end = felt_motion(frame_of(field), time).time;
  const double length = end - begin;
  if (time_before != kNoTime && length <= kLongestMotionGap)
    for (double at = begin + kPathStep; at < end - kPathStep / 2; at += kPathStep) {
      const PointerPosition place = place_at(path, at);
      append(motions,
             interpolated(felt_motion(sample_field(before, place), time_before),
                          felt_motion(sample_field(field, place), time), (at - begin) / length));
    }
  append(motions, felt_motion(sample_field(field, place_at(path, end)), time));
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
  track_ = read_track_file(path, stream);
  print_remarks(path, track_.remarks);
  leave_reliefs_out(path, track_);
}

std::optional<double> FeltFile::film_begin() const {
  return track_.is_untied || track_.film_begin == kNoTime
             ? std::nullopt
             : std::optional(seconds(track_.film_begin));
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
    if (path.empty() || middle > path.back().time)
      path.push_back({middle, sample.pointer_x, sample.pointer_y,
                      static_cast<float>(std::clamp(z, -1.0, 1.0))});
  }
  return path;
}

void FeltFile::feel(const Hands &hands, const ForceLaw &law, const TimeRange &range) {
  law_ = law;
  motions_.clear();
  surfaces_.clear();
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
  bool holds_any = false;
  const auto place = [&](auto &all) {
    add_to_times(all, offset_);
    std::erase_if(all,
                  [&](const auto &one) { return one.time < range.from || one.time >= range.to; });
    if (!all.empty() && !std::exchange(holds_any, true))
      set_times(all.front().time, all.back().time);
  };
  place(log_.forces);
  std::ranges::for_each(motions_, place);
  std::ranges::for_each(surfaces_, place);
  if (!holds_any)
    throw_error(messages::kNothingToCompare, path_.c_str());
}

void FeltFile::feel_fields(const Hands &hands) {
  motions_.resize(hands.count());
  MotionField before;
  std::uint64_t time_before = kNoTime;
  for_each_field(track_.fields, [&](const MotionField &field, std::uint64_t time) {
    if (hands.path.empty())
      for (std::size_t i = 0; i < hands.resting.size(); ++i)
        append(motions_[i], felt_motion(sample_field(field, hands.resting[i]), time));
    else
      append_along(hands.path, before, time_before, field, time, motions_.front());
    before = field;
    time_before = time;
  });
  if (time_before == kNoTime)
    throw_error(messages::kNoFieldIsDecoded);
}

void FeltFile::feel_reliefs(const Hands &hands) {
  surfaces_.resize(hands.path.empty() ? hands.count() : 0);
  ReliefField before;
  std::uint64_t time_before = kNoTime;
  bool has_surface = false;
  for_each_relief(track_.reliefs, [&](const ReliefField &relief, std::uint64_t time) {
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
      append(surfaces_[i], felt_surface(relief, hands.resting[i].x, hands.resting[i].y, time));
    if (!hands.path.empty())
      for (const TimedForce &force :
           touch_along(hands.path, time_before == kNoTime ? nullptr : &before, time_before, relief,
                       time, law_.max_force))
        append(log_.forces, force);
    has_surface = has_surface || std::ranges::any_of(relief.cells, [](const ReliefCell &cell) {
                    return cell.validity > 0;
                  });
    before = relief;
    time_before = time;
  });
  if (time_before == kNoTime)
    throw_error(messages::kNoFieldIsDecoded);
  if (!has_surface)
    throw_error(messages::kNoSurface, path_.c_str());
}

void FeltFile::set_times(double begin, double end) {
  if (!(end - begin <= kLongest))
    throw_error(messages::kTooLongToCompare, path_.c_str());
  begin_ = begin;
  end_ = end;
}

ForceSignal FeltFile::signal(std::size_t hand) const {
  if (motions_.empty())
    return signal_of_log(log_.forces);
  return signal_of_motions(motions_[std::min(hand, motions_.size() - 1)], law_);
}

} // namespace haptic
