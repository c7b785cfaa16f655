// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/hmpg-track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>
#include <utility>

namespace haptic {
namespace {

constexpr std::int64_t kLongestSilence = 3600 * std::int64_t{kTrackTimescale}; // ticks
constexpr std::size_t kEffectIds = 65536;                                      // of a band
constexpr std::int64_t kLongestHmpgEffect = 65535;                             // ticks: 16 bits
constexpr std::uint64_t kLongestTimeStep = kSecond / 200; // ns, of time stamps without a loss
constexpr std::size_t kMostEffects = 4096;                // at once
constexpr std::size_t kManyEffects = kMostEffects / 2;    // too many to wait for
constexpr std::size_t kMostHeldPoints = 2 * kMostForcePoints;
constexpr std::uint8_t kPerception = 0;
constexpr std::uint32_t kBandMask = 0xff0000; // of ChannelCurve::id
constexpr std::uint32_t kWhole = 0x1000000;   // of an effect that nothing continues

// A channel without a direction, or along z.
bool gives_none(const HmpgChannel &channel) {
  return !channel.direction || ((*channel.direction)[0] == 0 && (*channel.direction)[1] == 0);
}

// Of ChannelCurve.
std::uint32_t id_of(const HmpgCurve &effect) {
  return std::uint32_t{effect.band} << 16 | effect.effect;
}

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

// The ids of the effects of a band have 16 bits, and a reader may append the keyframes of an id
// that it knows to the old effect. So the track goes on in other bands when the ids are used up:
// 128 times for two bands, since theirs have 8 bits. Effects are then new by their independent
// units.
void HmpgEncoder::begin_bands() {
  effect_ = 0;
  for (auto &band : experience_.bands)
    band.id = static_cast<std::uint8_t>(band.id + experience_.bands.size());
  experience_.time = static_cast<std::uint32_t>(cursor_);
  emit(write_initialization_unit(experience_), UnitType::initialization, cursor_, cursor_);
}

void HmpgEncoder::close(std::int64_t end, const std::optional<CurveForce> &next) {
  if (points_.empty())
    return;
  end = std::max(end, points_.back().tick + 1);
  // The line ends one tick before the next unit begins: effects that share a tick add there.
  const ForcePoint last = points_.back();
  if (const std::int64_t tick = end - 1; tick > last.tick) {
    const CurveForce to = next.value_or(last.force);
    const double part =
        static_cast<double>(tick - last.tick) / static_cast<double>(end - last.tick);
    points_.push_back(
        {tick, {std::lerp(last.force.x, to.x, part), std::lerp(last.force.y, to.y, part)}});
  }
  if (effect_ + experience_.bands.size() > kEffectIds)
    begin_bands();
  std::array<HmpgCurve, 2> curves;
  for (std::size_t axis = 0; axis < curves.size(); ++axis) {
    curves[axis].channel = static_cast<std::uint16_t>(axis);
    curves[axis].band = experience_.bands[axis].id;
    curves[axis].effect = static_cast<std::uint16_t>(effect_++);
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
  last_end_ = tick + ticks_held(duration);
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
  if (unit.experience)
    return begin_experience(std::move(*unit.experience), time);
  if (!experience_)
    return {{}, "waiting for an initialization unit"};
  Result result = begin_unit(unit.header, time);
  const std::int64_t begin = *tick_;
  *tick_ += unit.header.duration;
  const char *problem = add_effects(unit, begin);
  if (const char *other = sample_until(known_until(), result.samples); !problem)
    problem = other;
  if (problem)
    result.problem = problem;
  result.unsupported = left_out(unit.has_composite);
  return result;
}

// Whether no keyframe follows, if those whose last one is before this tick do not go on. An effect
// that is closed may go on in the next unit.
bool HmpgDecoder::is_over(const ChannelCurve &curve, std::int64_t before) const {
  const std::int64_t last = curve.drawing.last(curve.points.back().tick);
  const bool is_whole = (curve.id & kWhole) != 0 && last <= *tick_; // later ones are not needed yet
  return last < before || is_whole || (curve.is_closed && last < *tick_ - 1);
}

// Returns the effect that begins where the curve has its last keyframe, or at the next tick. The
// curves are in the order of their beginnings: a hostile file has thousands of them in each unit.
std::vector<ChannelCurve>::iterator HmpgDecoder::next_of(const ChannelCurve &curve) {
  const std::int64_t last = curve.drawing.last(curve.points.back().tick);
  const auto begin = [](const ChannelCurve &one) { return one.points.front().tick; };
  const std::int64_t first = std::max(last, begin(curve) + 1); // at which one can touch it
  const auto behind = std::ranges::upper_bound(curves_, last + 1, {}, begin);
  const auto next = std::find_if(
      std::ranges::lower_bound(curves_, first, {}, begin), behind, [&](const ChannelCurve &one) {
        return (one.id & kBandMask) == (curve.id & kBandMask) && touches(curve, begin(one));
      });
  return next == behind ? curves_.end() : next;
}

// Ends the curves whose last point is before this tick: draws their rest, and joins them with the
// effect that follows. Then all are in the order of their beginnings.
void HmpgDecoder::end_curves(std::int64_t before) {
  for (auto &curve : curves_)
    if (curve.points.back().tick < before)
      curve.drawing.finish(curve.points);
  if (!std::ranges::is_sorted(curves_, begins_before)) // they may be many, and wait for long
    std::stable_sort(curves_.begin(), curves_.end(), begins_before);
  for (std::size_t i = 0; i < curves_.size(); ++i)
    while (is_over(curves_[i], before)) {
      ChannelCurve &curve = curves_[i];
      const auto next = next_of(curve);
      if (next == curves_.end())
        break;
      curve.drawing.finish(curve.points);
      join(curve, next->points);
      curve.drawing = std::move(next->drawing);
      curve.id = next->id;
      curve.begin = next->begin;
      curve.is_closed = next->is_closed;
      curves_.erase(next); // behind this one, since it begins later
    }
}

HmpgDecoder::Result HmpgDecoder::finish() {
  Result result;
  if (!tick_)
    return result;
  end_curves(std::numeric_limits<std::int64_t>::max());
  std::int64_t end = *tick_;
  for (const auto &curve : curves_)
    end = std::max(end, curve.points.back().tick + 1);
  if (!curves_.empty()) // silence behind them
    end += ticks_of(kUsualInterval, experience_->timescale) + 1;
  if (const char *problem = sample_until(end, result.samples))
    result.problem = problem;
  end_run();
  return result;
}

void HmpgDecoder::end_run() noexcept {
  curves_.clear();
  sampler_.restart();
  sampled_ = tick_.value_or(0);
}

// A sender repeats the initialization unit, or changes the bands, with the time of what follows.
HmpgDecoder::Result HmpgDecoder::begin_experience(HmpgExperience experience, std::uint64_t time) {
  const std::int64_t tick = experience.time;
  // With time stamps the ticks do not count.
  const bool goes_on = experience_ && experience_->timescale == experience.timescale && tick_ &&
                       (time != kNoTime || std::abs(tick - *tick_) <= 1);
  Result result;
  if (!goes_on) {
    result = finish();
    tick_ = tick;
    end_run();
    independent_go_on_ = false;
  }
  experience_ = std::move(experience);
  result.unsupported = left_out(false);
  const bool has_force = std::any_of(
      experience_->perceptions.begin(), experience_->perceptions.end(),
      [](const HmpgPerception &perception) { return perception.modality == kModalityForce; });
  if (!has_force)
    result.problem = "there is no perception of force in this stream";
  return result;
}

// Names what of the stream gives no force, or not the one of its curve; nothing if that was
// reported.
std::string HmpgDecoder::left_out(bool has_composite) {
  has_composite_ = has_composite_ || has_composite;
  const auto &e = *experience_;
  const auto is_force = [&](std::uint8_t id) {
    const auto perception = std::ranges::find(e.perceptions, id, &HmpgPerception::id);
    return perception != e.perceptions.end() && perception->modality == kModalityForce;
  };
  std::string what;
  const auto add = [&](bool is_there, const char *name) {
    if (is_there)
      what += (what.empty() ? "" : ", ") + std::string(name);
  };
  add(std::ranges::any_of(e.perceptions, [&](const auto &p) { return !is_force(p.id); }),
      kOtherPerceptions);
  add(std::ranges::any_of(e.channels,
                          [&](const auto &c) { return gives_none(c) && is_force(c.perception); }),
      kNoDirection);
  const auto any_band = [&](auto condition) {
    return std::ranges::any_of(e.bands, [&](const HmpgBand &band) {
      return is_force(band.perception) && condition(band);
    });
  };
  add(any_band([](const HmpgBand &band) { return band.type != BandType::curve; }), kOtherBands);
  add(any_band([](const HmpgBand &band) {
        return band.type == BandType::curve && !is_drawn(band.curve);
      }),
      kOtherCurves);
  add(has_composite_, kComposite);
  return what == left_out_ ? "" : left_out_ = what;
}

// Gives the ticks of the unit their time. Where units are missing, effects are not continued:
// returns what was held back of the units before.
HmpgDecoder::Result HmpgDecoder::begin_unit(const UnitHeader &header, std::uint64_t time) {
  Result result;
  if (!tick_) {
    tick_ = 0;
    end_run();
  }
  const double timescale = experience_->timescale;
  if (time == kNoTime) {
    clock_ = {timescale, *tick_, ns_of(*tick_, experience_->timescale)};
    return result;
  }
  const std::uint64_t expected = clock_.ns_at(*tick_);
  const std::uint64_t step = time > expected ? time - expected : expected - time;
  if (step > std::min(kLongestTimeStep, ns_of(header.duration, experience_->timescale) / 2)) {
    end_curves(std::numeric_limits<std::int64_t>::max());
    std::int64_t end = sampled_;
    for (const auto &curve : curves_)
      end = std::max(end, std::min(curve.points.back().tick + 1, *tick_));
    if (const char *problem = sample_until(end, result.samples))
      result.problem = problem;
    // The last tick only leads to the unit that is missing.
    if (!result.samples.empty() && result.samples.back().time == clock_.ns_at(*tick_ - 1))
      result.samples.pop_back();
    end_run();
  }
  clock_ = {timescale, *tick_, time};
  return result;
}

const char *HmpgDecoder::add_effects(const HmpgUnit &unit, std::int64_t begin) {
  if (unit.curves.size() > kMostEffects)
    return "too many effects at once";
  std::size_t points = 0;
  std::unordered_set<decltype(ChannelCurve::id)> known;
  for (const auto &curve : curves_) {
    points += curve.points.size();
    known.insert(curve.id);
  }
  const char *problem = nullptr;
  // First those that go on: where one has a keyframe, another effect may begin.
  std::vector<const HmpgCurve *> effects;
  effects.reserve(unit.curves.size());
  for (const auto &effect : unit.curves)
    effects.push_back(&effect);
  std::stable_partition( // not that of std::ranges, which Clang 14 cannot compile
      effects.begin(), effects.end(),
      [&](const HmpgCurve *effect) { return known.contains(id_of(*effect)); });
  for (const auto *effect : effects) {
    // Keyframes may be far in the future: without a limit they would gather for ever.
    auto curve = force_of(*effect, begin, kMostHeldPoints - std::min(points, kMostHeldPoints));
    if (!curve)
      continue;
    if (curve->points.empty()) {
      problem = "too many keyframes at once";
      continue;
    }
    const std::size_t drawn =
        add_effect(std::move(*curve), effect->reference.has_value(), unit.header, begin);
    points += drawn;
    if (drawn == 0)
      problem = "too many effects at once";
  }
  return problem;
}

// The keyframes of the effect as a force along its channel, or nothing where there is none. More
// keyframes than there is room for are left out, all of them.
std::optional<ChannelCurve> HmpgDecoder::force_of(const HmpgCurve &effect, std::int64_t begin,
                                                  std::size_t room) const {
  const auto &e = *experience_;
  const auto channel = std::ranges::find(e.channels, effect.channel, &HmpgChannel::id);
  const auto perception = std::ranges::find(e.perceptions, effect.perception, &HmpgPerception::id);
  const auto band = std::ranges::find(e.bands, effect.band, &HmpgBand::id);
  if (channel == e.channels.end() || perception == e.perceptions.end() || band == e.bands.end() ||
      perception->modality != kModalityForce || gives_none(*channel))
    return std::nullopt;
  std::span<const HmpgKeyframe> keyframes = effect.keyframes;
  if (effect.reference) {
    const auto id = std::pair(effect.perception, effect.effect);
    const auto named = std::ranges::lower_bound(e.library, id, {}, id_in_library);
    if (named != e.library.end() && id_in_library(*named) == id)
      keyframes = named->keyframes;
    begin += *effect.reference;
  }
  if (keyframes.empty())
    return std::nullopt;
  ChannelCurve curve;
  curve.direction = {(*channel->direction)[0] / 127.0, (*channel->direction)[1] / 127.0};
  curve.id = id_of(effect);
  curve.begin = begin + effect.begin;
  if (keyframes.size() > room)
    return curve;
  curve.points.reserve(keyframes.size());
  for (const auto &keyframe : keyframes)
    curve.points.push_back({begin + keyframe.position, amplitude_of_code(keyframe.amplitude)});
  const double scale = channel->gain * std::pow(10.0, perception->exponent);
  scale_values(curve, scale);
  curve.drawing = CurveDrawing(band->curve, scale);
  return curve;
}

// An effect went on in an independent unit, so none of this track is closed by its unit.
void HmpgDecoder::open_all() {
  independent_go_on_ = true;
  for (auto &curve : curves_)
    curve.is_closed = (curve.id & kWhole) != 0;
}

// An effect of an independent unit is new, though its id may be that of an older one, unless both
// begin at one tick: the reference encoder marks a unit independent when one effect begins in it,
// and others may go on. One of a library is whole. Returns the number of points, 0 if there is no
// room.
std::size_t HmpgDecoder::add_effect(ChannelCurve curve, bool is_whole, const UnitHeader &header,
                                    std::int64_t begin) {
  const std::vector<CurvePoint> keys = std::exchange(curve.points, {});
  const std::int64_t first = keys.front().tick;
  const auto same = std::ranges::find_if(curves_, [&](const ChannelCurve &known) {
    return (header.dependent || known.begin == curve.begin) && !is_whole && known.id == curve.id &&
           known.drawing.last(known.points.back().tick) <= first;
  });
  if (same != curves_.end()) {
    const std::size_t before = same->points.size();
    same->drawing.append(keys, same->points);
    same->is_closed = false;
    if (!header.dependent)
      open_all();
    return same->points.size() - before + keys.size();
  }
  curve.drawing.append(keys, curve.points);
  if (is_whole)
    curve.drawing.finish(curve.points);
  curve.is_closed =
      is_whole || (!header.dependent && !independent_go_on_ && !curve.drawing.waits() &&
                   keys.size() > 1 && keys.back().tick >= begin + header.duration - 1);
  const std::size_t points = curve.points.size();
  if (is_whole)
    curve.id |= kWhole;
  if (curves_.size() == kMostEffects)
    return 0;
  curves_.push_back(std::move(curve));
  return points;
}

// Until when the force is known. An effect may go on for as long as a keyframe may be from its
// beginning; the last keyframe of one that is closed may belong to a line into the next unit.
std::int64_t HmpgDecoder::known_until() {
  const std::int64_t end = *tick_;
  const std::int64_t patience =
      is_live_ ? ticks_of(ns_of(kLongestHold, kTrackTimescale), experience_->timescale)
               : kLongestHmpgEffect;
  end_curves(end - patience);
  std::int64_t until = end;
  std::size_t points = 0;
  for (const auto &curve : curves_) {
    const std::int64_t last = curve.points.back().tick;
    points += curve.points.size();
    if (curve.is_closed ? last >= end - 1 : last < end && end - last <= patience)
      until = std::min(until, curve.is_closed ? end - 1 : last + 1);
    // Which of two counts at one tick is known when the first one goes on, or is over.
    if (last <= end && !is_over(curve, end - patience) && next_of(curve) != curves_.end())
      until = std::min(until, last - 1);
  }
  if (points > kMostForcePoints || curves_.size() > kManyEffects) {
    end_curves(end);
    until = end;
  }
  return std::max(until, sampled_);
}

const char *HmpgDecoder::sample_until(std::int64_t end, std::vector<TrackSample> &samples) {
  const char *problem = sampler_.append(curves_, sampled_, end, clock_, samples);
  sampled_ = end;
  const std::int64_t next = *tick_; // unit
  const bool are_many = curves_.size() > kManyEffects;
  std::erase_if(curves_, [&](const ChannelCurve &curve) {
    const std::int64_t last = curve.points.back().tick;
    return last < sampled_ &&
           (are_many || next - last > kLongestHmpgEffect || (curve.is_closed && last < next - 1));
  });
  // One point before is needed for the line to the next.
  for (auto &curve : curves_) {
    auto &points = curve.points;
    const auto kept = std::find_if(points.begin(), points.end(),
                                   [&](const auto &point) { return point.tick >= sampled_ - 1; });
    if (kept - points.begin() > 1)
      points.erase(points.begin(), kept - 1);
  }
  return problem;
}

} // namespace haptic
