// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads .hjif: ISO/IEC 23090-31:2025, clause 6.2 (HJIF specifications).
#include "force-curve.hpp"
#include "hjif.hpp"
#include "json-events.hpp"
#include "track-time.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

namespace haptic {
namespace {

constexpr std::size_t kMostKeyframes = 1'000'000; // nine hours of 30 a second
constexpr double kLatest = 1e9;                   // ticks
constexpr double kLongestDirection = 127;         // 6.2.7: MPEG_haptics.vector, signed bytes
constexpr double kLargestExponent = 30;
constexpr double kHighestTimescale = 48000; // ticks/s, Main profile

// ---- where the reader is ------------------------------------------------------------------------

// The objects of the format from the outermost on, with their clause of ISO/IEC 23090-31:2025.
enum class Level { experience, perception, channel, direction, band, effect, keyframe };

enum class Member {
  none,
  version, // 6.2.1 MPEG_haptics
  timescale,
  perceptions,
  modality, // 6.2.3 MPEG_haptics.perception
  exponent,
  channels,
  gain, // 6.2.6 MPEG_haptics.channel
  direction,
  bands,
  part,      // 6.2.7 MPEG_haptics.vector: X, Y, Z
  band_type, // 6.2.8 MPEG_haptics.band
  effects,
  effect_type, // an effect, data model: clause 5.8
  position,
  keyframes,
  relative_position, // a keyframe, data model: clause 5.9
  amplitude
};

enum class Kind { number, text, object, array };

struct Rule {
  Level level;
  std::string_view name;
  Member member;
  Kind kind;
};

constexpr Rule kRules[] = {
    {Level::experience, "version", Member::version, Kind::text},
    {Level::experience, "timescale", Member::timescale, Kind::number},
    {Level::experience, "perceptions", Member::perceptions, Kind::array},
    {Level::perception, "perception_modality", Member::modality, Kind::text},
    {Level::perception, "perception_unit_exponent", Member::exponent, Kind::number},
    {Level::perception, "channels", Member::channels, Kind::array},
    {Level::channel, "gain", Member::gain, Kind::number},
    {Level::channel, "direction", Member::direction, Kind::object},
    {Level::channel, "bands", Member::bands, Kind::array},
    {Level::band, "band_type", Member::band_type, Kind::text},
    {Level::band, "effects", Member::effects, Kind::array},
    {Level::effect, "effect_type", Member::effect_type, Kind::text},
    {Level::effect, "position", Member::position, Kind::number},
    {Level::effect, "keyframes", Member::keyframes, Kind::array},
    {Level::keyframe, "relative_position", Member::relative_position, Kind::number},
    {Level::keyframe, "amplitude_modulation", Member::amplitude, Kind::number},
};

const char *wrong_kind(Kind expected) {
  switch (expected) {
  case Kind::number:
    return "a number is expected";
  case Kind::text:
    return "a text is expected";
  case Kind::object:
    return "an object is expected";
  case Kind::array:
    return "an array is expected";
  }
  return nullptr;
}

Level level_within(Member member) {
  switch (member) {
  case Member::perceptions:
    return Level::perception;
  case Member::channels:
    return Level::channel;
  case Member::direction:
    return Level::direction;
  case Member::bands:
    return Level::band;
  case Member::effects:
    return Level::effect;
  case Member::keyframes:
    return Level::keyframe;
  default:
    return Level::experience;
  }
}

// ---- what is read -------------------------------------------------------------------------------

struct Perception {
  std::vector<ChannelCurve> curves;
  double exponent = 0;
  bool is_force = false;
};

struct Channel {
  std::vector<ChannelCurve> curves;
  double gain = 1;
  std::optional<std::array<double, 2>> direction;
};

struct Band {
  std::vector<ChannelCurve> curves;
  bool is_curve = false;
};

struct Effect {
  ChannelCurve curve;
  double position = 0;
  bool is_basis = false;
};

void move_to(std::vector<ChannelCurve> &curves, std::vector<ChannelCurve> &all) {
  std::move(curves.begin(), curves.end(), std::back_inserter(all));
}

// Builds the curves of force while the events come. A value that no rule names is passed over with
// all that it holds.
class HjifHandler final : public JsonHandler {
public:
  const char *begin_object() override {
    if (passes_over())
      return nullptr;
    if (!has_root_) {
      has_root_ = true;
      levels_.push_back(Level::experience);
      return nullptr;
    }
    const bool is_element = !arrays_.empty() && arrays_.back().depth == levels_.size();
    if (!is_element && kind_ != Kind::object)
      return wrong_kind(kind_);
    const Level level = is_element ? arrays_.back().level : level_within(member_);
    levels_.push_back(level);
    begin(level);
    return nullptr;
  }
  const char *end_object() override {
    if (comes_back())
      return nullptr;
    const Level level = levels_.back();
    levels_.pop_back();
    return end(level);
  }
  const char *begin_array() override {
    if (passes_over())
      return nullptr;
    if (const char *wrong = check(Kind::array))
      return wrong;
    arrays_.push_back({level_within(member_), levels_.size()});
    return nullptr;
  }
  const char *end_array() override {
    if (!comes_back())
      arrays_.pop_back();
    return nullptr;
  }
  const char *key(std::string_view name) override {
    if (passed_ > 0)
      return nullptr;
    const Level level = levels_.back();
    member_ = Member::none;
    if (level == Level::direction) {
      member_ = Member::part;
      kind_ = Kind::number;
      axis_ = name;
      return nullptr;
    }
    for (const Rule &rule : kRules)
      if (rule.level == level && rule.name == name) {
        member_ = rule.member;
        kind_ = rule.kind;
      }
    return nullptr;
  }
  const char *number(double value) override {
    if (is_passed_over())
      return nullptr;
    if (const char *wrong = check(Kind::number))
      return wrong;
    return store(value);
  }
  const char *text(std::string_view value) override {
    if (is_passed_over())
      return nullptr;
    if (const char *wrong = check(Kind::text))
      return wrong;
    store(value);
    return nullptr;
  }
  const char *word() override { return is_passed_over() ? nullptr : check(std::nullopt); }

  /// What is wrong with the whole, or nothing.
  const char *missing() const {
    if (!has_version_)
      return "there is no version: this is not MPEG haptics";
    if (!(timescale_ > 0 && timescale_ <= kHighestTimescale))
      return "the timescale is missing or impossible";
    return has_force_ ? nullptr : "there is no perception of force";
  }
  double timescale() const { return timescale_; }
  std::vector<ChannelCurve> &curves() { return curves_; }

private:
  struct Array {
    Level level; // of its elements
    std::size_t depth;
  };

  bool is_in_array() const { return !arrays_.empty() && arrays_.back().depth == levels_.size(); }
  bool is_passed_over() const {
    return passed_ > 0 || (has_root_ && !is_in_array() && member_ == Member::none);
  }
  // For the begin and the end of an object or array.
  bool passes_over() {
    if (is_passed_over())
      ++passed_;
    return passed_ > 0;
  }
  bool comes_back() { return passed_ > 0 && passed_-- > 0; }

  // The value that comes must be of the kind that its place demands; `none` is a word.
  const char *check(std::optional<Kind> kind) const {
    const Kind expected = !has_root_ || is_in_array() ? Kind::object : kind_;
    return kind == expected ? nullptr : wrong_kind(expected);
  }

  void begin(Level level) {
    switch (level) {
    case Level::perception:
      perception_ = {};
      break;
    case Level::channel:
      channel_ = {};
      break;
    case Level::direction:
      channel_.direction.emplace();
      break;
    case Level::band:
      band_ = {};
      break;
    case Level::effect:
      effect_ = {};
      break;
    case Level::keyframe:
      keyframe_ = {};
      keyframe_tick_ = 0;
      break;
    case Level::experience:
      break;
    }
  }

  const char *end(Level level) {
    switch (level) {
    case Level::perception:
      return end_perception();
    case Level::channel:
      end_channel();
      break;
    case Level::band:
      if (band_.is_curve)
        move_to(band_.curves, channel_.curves);
      break;
    case Level::effect:
      end_effect();
      break;
    case Level::keyframe:
      return end_keyframe();
    default:
      break;
    }
    return nullptr;
  }

  const char *store(double value) {
    switch (member_) {
    case Member::timescale:
      timescale_ = value;
      break;
    case Member::exponent:
      perception_.exponent = value;
      break;
    case Member::gain:
      channel_.gain = value;
      break;
    case Member::part:
      return store_part(value);
    case Member::position:
      return store_tick(value, effect_.position);
    case Member::relative_position:
      return store_tick(value, keyframe_tick_);
    case Member::amplitude:
      keyframe_.value = value;
      break;
    default:
      break;
    }
    return nullptr;
  }

  void store(std::string_view value) {
    if (member_ == Member::version)
      has_version_ = value.starts_with("20");
    else if (member_ == Member::modality)
      perception_.is_force = value == "Force";
    else if (member_ == Member::band_type)
      band_.is_curve = value == "Curve";
    else if (member_ == Member::effect_type)
      effect_.is_basis = value == "Basis";
  }

  const char *store_part(double value) {
    if (!(std::abs(value) <= kLongestDirection))
      return "an impossible direction";
    if (axis_ == "X")
      (*channel_.direction)[0] = value / kLongestDirection;
    else if (axis_ == "Y")
      (*channel_.direction)[1] = value / kLongestDirection;
    return nullptr;
  }

  static const char *store_tick(double value, double &tick) {
    if (!(value >= 0 && value <= kLatest))
      return "an impossible position";
    tick = std::round(value);
    return nullptr;
  }

  // newtons = amplitude * gain * 10^exponent (clause 5.4, perception_unit_exponent), 1 N at most.
  const char *end_perception() {
    if (!perception_.is_force)
      return nullptr;
    has_force_ = true;
    if (!(std::abs(perception_.exponent) <= kLargestExponent))
      return "an impossible exponent";
    const double scale = std::pow(10.0, perception_.exponent);
    for (auto &curve : perception_.curves)
      for (auto &point : curve.points)
        point.value = std::clamp(point.value * scale, -1.0, 1.0);
    move_to(perception_.curves, curves_);
    return nullptr;
  }

  void end_channel() {
    if (!channel_.direction)
      return;
    for (auto &curve : channel_.curves) {
      curve.direction = *channel_.direction;
      for (auto &point : curve.points)
        point.value *= channel_.gain;
    }
    move_to(channel_.curves, perception_.curves);
  }

  void end_effect() {
    for (auto &point : effect_.curve.points)
      point.tick += static_cast<std::int64_t>(effect_.position);
    if (effect_.is_basis && !effect_.curve.points.empty())
      band_.curves.push_back(std::move(effect_.curve));
  }

  const char *end_keyframe() {
    auto &points = effect_.curve.points;
    keyframe_.tick = static_cast<std::int64_t>(keyframe_tick_);
    if (!(std::abs(keyframe_.value) <= 1))
      return "an amplitude beyond 1";
    if (++keyframes_ > kMostKeyframes)
      return "too many keyframes";
    if (!points.empty() && keyframe_.tick < points.back().tick)
      return "keyframes run backwards";
    points.push_back(keyframe_);
    return nullptr;
  }

  // Where the reader is.
  bool has_root_ = false;
  std::vector<Level> levels_; // the objects that are open
  std::vector<Array> arrays_; // the arrays that are open
  int passed_ = 0;            // open objects and arrays within a value that is passed over
  Member member_ = Member::none;
  Kind kind_ = Kind::object; // what member_ must be
  std::string axis_;         // of Member::part

  // What it has read of the objects that are open.
  Perception perception_;
  Channel channel_;
  Band band_;
  Effect effect_;
  ChannelCurve::Point keyframe_;
  double keyframe_tick_ = 0;

  bool has_version_ = false;
  bool has_force_ = false;
  double timescale_ = 0;
  std::size_t keyframes_ = 0;
  std::vector<ChannelCurve> curves_;
};

// ---- samples ------------------------------------------------------------------------------------

using Span = std::pair<std::int64_t, std::int64_t>; // ticks, [begin, end)

// The times that the curves cover, joined where they overlap or touch.
std::vector<Span> stretches_of(std::span<const ChannelCurve> curves) {
  std::vector<Span> spans;
  for (const auto &curve : curves)
    spans.emplace_back(curve.points.front().tick, curve.points.back().tick + 1);
  std::sort(spans.begin(), spans.end());
  std::vector<Span> stretches;
  for (const auto &span : spans) {
    if (stretches.empty() || span.first > stretches.back().second)
      stretches.push_back(span);
    else
      stretches.back().second = std::max(stretches.back().second, span.second);
  }
  return stretches;
}

std::uint64_t ns_of_ticks(std::int64_t ticks, double timescale) {
  return static_cast<std::uint64_t>(
      std::llround(static_cast<double>(ticks) / timescale * static_cast<double>(kSecond)));
}

void append_samples(std::vector<TrackSample> &samples, const std::vector<ForcePoint> &points,
                    double timescale) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    TrackSample sample;
    sample.motion = motion_of_force(points[i].force);
    sample.time = ns_of_ticks(points[i].tick, timescale);
    sample.duration = i + 1 < points.size()
                          ? ns_of_ticks(points[i + 1].tick, timescale) - sample.time
                          : kUsualInterval;
    sample.motion.interval = std::min(sample.duration, kUsualInterval * 3);
    samples.push_back(sample);
  }
  const TrackSample &last = samples.back();
  samples.push_back(silent_sample(last.time + last.duration, kUsualInterval));
}

// Stretch by stretch, since only so many points are summed at once.
const char *make_samples(std::vector<ChannelCurve> &curves, double timescale,
                         std::vector<TrackSample> &samples) {
  const auto stretches = stretches_of(curves);
  std::sort(curves.begin(), curves.end(), [](const auto &a, const auto &b) {
    return a.points.front().tick < b.points.front().tick;
  });
  std::size_t used = 0;
  for (const auto &[begin, end] : stretches) {
    const std::size_t first = used;
    while (used < curves.size() && curves[used].points.front().tick < end)
      ++used;
    const auto points = sum_curves(std::span(curves).subspan(first, used - first), begin, end);
    if (points.empty())
      return "too many keyframes in one stretch";
    append_samples(samples, points, timescale);
  }
  return nullptr;
}

} // namespace

HjifTrack read_hjif(std::string_view text) {
  HjifHandler handler;
  HjifTrack track;
  if (const auto error = parse_json(text, handler)) {
    track.error = error->what;
    track.offset = error->offset;
    return track;
  }
  const char *wrong = handler.missing();
  if (!wrong)
    wrong = make_samples(handler.curves(), handler.timescale(), track.samples);
  if (wrong) {
    track = {};
    track.error = wrong;
    track.offset = text.size();
  }
  return track;
}

} // namespace haptic
