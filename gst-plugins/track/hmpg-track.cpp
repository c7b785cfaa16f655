// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hmpg-track.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr std::int64_t kLongestSilence = 3600 * std::int64_t{kTrackTimescale}; // ticks
constexpr std::uint8_t kPerception = 0;

} // namespace

HmpgExperience track_experience(std::string date) {
  HmpgExperience e;
  e.timescale = kTrackTimescale;
  e.date = std::move(date);
  e.description = "Motion under a pointer in a picture, as a force";
  e.perceptions = {{kPerception, kModalityForce, 0, "Force along the motion"}};
  e.channels = {{0, kPerception, 1, {{127, 0, 0}}, "to the right"},
                {1, kPerception, 1, {{0, 127, 0}}, "up"}};
  e.bands = {{0, kPerception, 0, BandType::curve, CurveType::linear},
             {1, kPerception, 1, BandType::curve, CurveType::linear}};
  return e;
}

HmpgEncoder::HmpgEncoder(std::uint64_t unit_duration, std::string date)
    : experience_(track_experience(std::move(date))),
      unit_ticks_(std::max<std::int64_t>(1, ticks_of(unit_duration, kTrackTimescale))) {
  experience_.nominal = static_cast<std::uint32_t>(unit_ticks_);
  experience_.deviation = static_cast<std::uint32_t>(kLongestHold);
}

void HmpgEncoder::emit(std::vector<std::uint8_t> bytes, UnitType type, std::int64_t begin,
                       std::int64_t end) {
  const std::uint64_t from = ns_of(begin, kTrackTimescale);
  done_.push_back({std::move(bytes), from, ns_of(end, kTrackTimescale) - from, type});
}

void HmpgEncoder::begin(std::int64_t tick) {
  started_ = true;
  points_.clear();
  cursor_ = last_end_ = tick;
  experience_.time = static_cast<std::uint32_t>(tick);
  emit(write_initialization_unit(experience_), UnitType::initialization, tick, tick);
}

void HmpgEncoder::close(std::int64_t end, const std::optional<CurveForce> &next) {
  if (points_.empty())
    return;
  end = std::max(end, points_.back().tick + 1);
  // The last keyframe is where the next unit begins, so that the line has no gap.
  points_.push_back({end, next.value_or(points_.back().force)});
  std::array<HmpgCurve, 2> curves;
  for (std::size_t axis = 0; axis < curves.size(); ++axis) {
    curves[axis].channel = static_cast<std::uint16_t>(axis);
    curves[axis].band = static_cast<std::uint8_t>(axis);
    curves[axis].effect = effect_++;
    for (const auto &point : points_)
      curves[axis].keyframes.push_back(
          {static_cast<std::int32_t>(point.tick - cursor_),
           code_of_amplitude(axis == 0 ? point.force.x : point.force.y)});
  }
  emit(write_temporal_unit(static_cast<std::uint32_t>(end - cursor_), curves), UnitType::temporal,
       cursor_, end);
  points_.clear();
  cursor_ = end;
}

void HmpgEncoder::silence(std::int64_t until) {
  constexpr std::int64_t kLongest = (1 << 24) - 1; // of a unit, ticks
  while (cursor_ < until) {
    const std::int64_t end = std::min(until, cursor_ + kLongest);
    emit(write_silent_unit(static_cast<std::uint32_t>(end - cursor_)), UnitType::silent, cursor_,
         end);
    cursor_ = end;
  }
}

std::vector<CodedUnit> HmpgEncoder::push(const MotionSample &sample, std::uint64_t time,
                                         std::uint64_t duration) {
  done_.clear();
  const std::int64_t tick = ticks_of(time, kTrackTimescale);
  const bool back = tick < cursor_ || (!points_.empty() && tick < points_.back().tick);
  if (!started_ || back || tick - cursor_ > kLongestSilence) {
    close(last_end_, std::nullopt);
    begin(tick);
  }
  if (!points_.empty() && tick == points_.back().tick)
    return std::move(done_); // two of one time
  const bool felt = is_felt(sample);
  const CurveForce force = force_of_motion(sample);
  if (!points_.empty()) {
    const bool goes_on = felt && tick - points_.back().tick <= kLongestHold;
    if (!goes_on)
      close(std::min(tick, std::max(last_end_, points_.back().tick + 1)), std::nullopt);
    else if (tick - cursor_ >= unit_ticks_)
      close(tick, force);
  }
  if (felt) {
    if (points_.empty())
      silence(tick);
    points_.push_back({tick, force});
  } else if (tick - cursor_ >= unit_ticks_) {
    silence(tick);
  }
  last_end_ =
      tick + std::clamp<std::int64_t>(
                 ticks_of(duration == kNoTime ? kUsualInterval : std::min(duration, kSecond),
                          kTrackTimescale),
                 1, kLongestHold);
  return std::move(done_);
}

std::vector<CodedUnit> HmpgEncoder::finish() {
  done_.clear();
  if (started_) {
    close(last_end_, std::nullopt);
    silence(cursor_ + unit_ticks_);
  }
  started_ = false;
  return std::move(done_);
}

HmpgDecoder::Result HmpgDecoder::push(std::span<const std::uint8_t> bytes, std::uint64_t time) {
  HmpgUnit unit = read_unit(bytes, experience_ ? &*experience_ : nullptr);
  if (unit.error) {
    // The header alone gives its duration.
    if (const auto header = read_unit_header(bytes); header && tick_)
      *tick_ += header->duration;
    return {{},
            std::string(unit.error->what) + " (at byte " + std::to_string(unit.error->offset) +
                " of the unit)"};
  }
  if (unit.experience) {
    tick_ = unit.experience->time;
    experience_ = std::move(unit.experience);
    const bool has_force = std::any_of(
        experience_->perceptions.begin(), experience_->perceptions.end(),
        [](const HmpgPerception &perception) { return perception.modality == kModalityForce; });
    return {{}, has_force ? "" : "there is no perception of force in this stream"};
  }
  if (!experience_)
    return {{}, "waiting for an initialization unit"};
  const std::uint32_t timescale = experience_->timescale;
  const std::uint64_t begin = time != kNoTime ? time : ns_of(tick_.value_or(0), timescale);
  tick_ = tick_.value_or(0) + unit.header.duration;
  switch (unit.header.type) {
  case UnitType::temporal:
    return read_temporal(unit, begin);
  case UnitType::silent:
    last_ = kNoTime;
    return {{silent_sample(begin, ns_of(unit.header.duration, timescale))}, ""};
  default:
    return {};
  }
}

HmpgDecoder::Result HmpgDecoder::read_temporal(const HmpgUnit &unit, std::uint64_t begin) {
  std::vector<ChannelCurve> curves;
  for (const auto &curve : unit.curves) {
    const auto same = [](auto id) { return [id](const auto &item) { return item.id == id; }; };
    const auto channel = std::find_if(experience_->channels.begin(), experience_->channels.end(),
                                      same(curve.channel));
    const auto perception = std::find_if(experience_->perceptions.begin(),
                                         experience_->perceptions.end(), same(curve.perception));
    if (channel == experience_->channels.end() || perception == experience_->perceptions.end() ||
        perception->modality != kModalityForce || !channel->direction)
      continue;
    const double gain = channel->gain * std::pow(10.0, perception->exponent);
    ChannelCurve sum;
    sum.direction = {(*channel->direction)[0] / 127.0, (*channel->direction)[1] / 127.0};
    sum.points.reserve(curve.keyframes.size());
    for (const auto &keyframe : curve.keyframes)
      sum.points.push_back(
          {keyframe.position, std::clamp(amplitude_of_code(keyframe.amplitude) * gain, -1.0, 1.0)});
    curves.push_back(std::move(sum));
  }
  const auto points = sum_curves(curves, 0, unit.header.duration);
  const std::uint32_t timescale = experience_->timescale;
  Result result;
  result.samples.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    TrackSample sample;
    sample.motion = motion_of_force(points[i].force);
    sample.time = begin + ns_of(points[i].tick, timescale);
    const std::int64_t until = i + 1 < points.size() ? points[i + 1].tick : unit.header.duration;
    sample.duration = ns_of(until - points[i].tick, timescale);
    const std::uint64_t since =
        last_ != kNoTime && last_ < sample.time ? sample.time - last_ : kNoTime;
    sample.motion.interval = std::min(since, std::min(sample.duration, kUsualInterval * 3));
    last_ = sample.time;
    result.samples.push_back(sample);
  }
  return result;
}

} // namespace haptic
