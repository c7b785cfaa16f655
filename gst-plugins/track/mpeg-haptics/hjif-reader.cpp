// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads .hjif: ISO/IEC 23090-31:2025, clause 6.2 (HJIF specifications).
#include "core/track-time.hpp"
#include "mpeg-haptics/force-curve.hpp"
#include "mpeg-haptics/hjif.hpp"
#include "mpeg-haptics/json-events.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

namespace haptic {
namespace {

constexpr std::size_t kMostKeyframes = 1'000'000; // nine hours of 30 a second
constexpr std::size_t kMostPoints = 4'000'000;
constexpr double kLatest = 1e9;           // ticks
constexpr double kLongestDirection = 127; // 6.2.7: MPEG_haptics.vector, signed bytes
// At level 1.
constexpr std::size_t kMostChannels = 127;
constexpr std::size_t kMostBands = 7; // of a channel
constexpr double kLargestExponent = 30;
constexpr double kHighestTimescale = 48000; // ticks/s, Main profile
constexpr std::ptrdiff_t kMostAtOnce = 16;  // effects of one band that may overlap
constexpr double kFinalSilence = 1.0 / 30;  // s

// ---- where the reader is ------------------------------------------------------------------------

// The objects of the format from the outermost on, with their clause of ISO/IEC 23090-31:2025.
enum class Level { experience, perception, channel, direction, band, effect, keyframe };

enum class Member {
  none,
  version, // 6.2.1 MPEG_haptics
  level,
  timescale,
  perceptions,
  modality, // 6.2.3 MPEG_haptics.perception
  exponent,
  library,
  channels,
  gain, // 6.2.6 MPEG_haptics.channel
  direction,
  bands,
  part,      // 6.2.7 MPEG_haptics.vector: X, Y, Z
  band_type, // 6.2.8 MPEG_haptics.band
  curve_type,
  effects,
  effect_type, // an effect, data model: clause 5.8
  id,
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
    {Level::experience, "level", Member::level, Kind::number},
    {Level::experience, "timescale", Member::timescale, Kind::number},
    {Level::experience, "perceptions", Member::perceptions, Kind::array},
    {Level::perception, "perception_modality", Member::modality, Kind::text},
    {Level::perception, "perception_unit_exponent", Member::exponent, Kind::number},
    {Level::perception, "effect_library", Member::library, Kind::array},
    {Level::perception, "channels", Member::channels, Kind::array},
    {Level::channel, "gain", Member::gain, Kind::number},
    {Level::channel, "direction", Member::direction, Kind::object},
    {Level::channel, "bands", Member::bands, Kind::array},
    {Level::band, "band_type", Member::band_type, Kind::text},
    {Level::band, "curve_type", Member::curve_type, Kind::text},
    {Level::band, "effects", Member::effects, Kind::array},
    {Level::effect, "effect_type", Member::effect_type, Kind::text},
    {Level::effect, "id", Member::id, Kind::number},
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
  case Member::library:
  case Member::effects:
    return Level::effect;
  case Member::keyframes:
    return Level::keyframe;
  default:
    return Level::experience;
  }
}

// ---- what is read -------------------------------------------------------------------------------

enum class EffectType { unknown, basis, reference, composite };

struct Effect {
  std::vector<CurvePoint> keys;
  double position = 0;
  double id = -1;
  EffectType type = EffectType::unknown;
};

struct Band {
  std::vector<Effect> effects;
  CurveType curve = CurveType::unknown;
  bool is_known = false;
  bool is_curve = false;
};

struct Channel {
  std::vector<Band> bands;
  double gain = 1;
  std::optional<std::array<double, 3>> direction; // right, up, towards the user

  bool is_felt() const { return direction && ((*direction)[0] != 0 || (*direction)[1] != 0); }
};

struct Perception {
  std::vector<Channel> channels;
  std::map<double, std::vector<CurvePoint>> library; // curves by their id
  double exponent = 0;
  bool is_force = false;
};

CurveType curve_type_of(std::string_view name) {
  constexpr std::pair<std::string_view, CurveType> kTypes[] = {{"Cubic", CurveType::cubic},
                                                               {"Linear", CurveType::linear},
                                                               {"Akima", CurveType::akima},
                                                               {"Bezier", CurveType::bezier},
                                                               {"Bspline", CurveType::bspline}};
  const auto *type = std::ranges::find(kTypes, name, [](const auto &pair) { return pair.first; });
  return type == std::end(kTypes) ? CurveType::unknown : type->second;
}

// Effects of one band that follow each other without a pause are one curve.
void join_effects(std::vector<ChannelCurve> &curves) {
  std::stable_sort(curves.begin(), curves.end(), begins_before);
  std::vector<ChannelCurve> joined;
  for (auto &curve : curves) {
    const auto recent = joined.end() - std::min<std::ptrdiff_t>(kMostAtOnce, std::ssize(joined));
    const auto before = std::find_if(recent, joined.end(), [&](const ChannelCurve &known) {
      return touches(known, curve.points.front().tick);
    });
    if (before != joined.end())
      join(*before, curve.points);
    else
      joined.push_back(std::move(curve));
  }
  curves = std::move(joined);
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
    if (level_ == 1 && (channels_ > kMostChannels || bands_ > kMostBands))
      return "more channels, or bands of one, than level 1 has";
    return has_force_ ? nullptr : "there is no perception of force";
  }
  double timescale() const { return timescale_; }
  std::vector<ChannelCurve> &curves() { return curves_; }
  /// What of the track gives no force, or not the one of its curve.
  std::string left_out() const {
    std::string what;
    for (const char *name : left_out_)
      what += (what.empty() ? "" : ", ") + std::string(name);
    return what;
  }

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
      ++channels_;
      bands_ = std::max(bands_, channel_.bands.size());
      perception_.channels.push_back(std::move(channel_));
      break;
    case Level::direction:
      return end_direction();
    case Level::band:
      channel_.bands.push_back(std::move(band_));
      break;
    case Level::effect:
      return end_effect();
    case Level::keyframe:
      return end_keyframe();
    default:
      break;
    }
    return nullptr;
  }

  const char *store(double value) {
    switch (member_) {
    case Member::level:
      level_ = value;
      break;
    case Member::timescale:
      timescale_ = value;
      break;
    case Member::exponent:
      perception_.exponent = value;
      break;
    case Member::gain:
      channel_.gain = value;
      return value < 0 ? "a negative gain" : nullptr;
    case Member::part:
      return store_part(value);
    case Member::id:
      effect_.id = value;
      break;
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
      store_band_type(value);
    else if (member_ == Member::curve_type)
      band_.curve = curve_type_of(value);
    else if (member_ == Member::effect_type)
      effect_.type = value == "Basis"       ? EffectType::basis
                     : value == "Reference" ? EffectType::reference
                     : value == "Composite" ? EffectType::composite
                                            : EffectType::unknown;
  }

  void store_band_type(std::string_view value) {
    band_.is_curve = value == "Curve";
    band_.is_known = band_.is_curve || value == "Transient" || value == "VectorialWave" ||
                     value == "WaveletWave";
  }

  const char *store_part(double value) {
    if (!(std::abs(value) <= kLongestDirection))
      return "an impossible direction";
    if (axis_ == "X")
      (*channel_.direction)[0] = value / kLongestDirection;
    else if (axis_ == "Y")
      (*channel_.direction)[1] = value / kLongestDirection;
    else if (axis_ == "Z")
      (*channel_.direction)[2] = value / kLongestDirection;
    return nullptr;
  }

  // As the reference software checks it.
  const char *end_direction() const {
    const auto &[x, y, z] = *channel_.direction;
    const double length = std::hypot(x, y, z);
    return length >= 0.99 && length <= 1.01 ? nullptr : "a direction whose length is not 127";
  }

  static const char *store_tick(double value, double &tick) {
    if (!(value >= 0 && value <= kLatest))
      return "an impossible position";
    tick = std::round(value);
    return nullptr;
  }

  // newtons = amplitude * gain * 10^exponent (clause 5.4, perception_unit_exponent).
  const char *end_perception() {
    leave_out(!perception_.is_force, kOtherPerceptions);
    if (!perception_.is_force)
      return nullptr;
    has_force_ = true;
    if (!(std::abs(perception_.exponent) <= kLargestExponent))
      return "an impossible exponent";
    for (auto &channel : perception_.channels) {
      leave_out(!channel.is_felt(), kNoDirection);
      if (channel.is_felt())
        for (auto &band : channel.bands)
          if (const char *wrong = end_band(channel, band))
            return wrong;
    }
    return nullptr;
  }

  // Draws the effects of the band. Those of a library are known only at the end of its perception.
  const char *end_band(const Channel &channel, Band &band) {
    if (!band.is_known)
      return "a band of no known type";
    leave_out(!band.is_curve, kOtherBands);
    leave_out(band.is_curve && !is_drawn(band.curve), kOtherCurves);
    if (!band.is_curve)
      return nullptr;
    const double scale = std::pow(10.0, perception_.exponent);
    std::vector<ChannelCurve> curves;
    for (Effect &effect : band.effects) {
      const auto named = perception_.library.find(effect.id);
      if (effect.type == EffectType::reference) {
        if (named == perception_.library.end())
          return "a reference to no effect of the library";
        effect.keys = named->second;
      }
      leave_out(effect.type == EffectType::composite, kComposite);
      if (effect.type == EffectType::composite || effect.keys.empty())
        continue;
      for (auto &key : effect.keys)
        key.tick += static_cast<std::int64_t>(effect.position);
      ChannelCurve curve;
      curve.direction = {(*channel.direction)[0], (*channel.direction)[1]};
      curve.points = std::move(effect.keys);
      scale_values(curve, channel.gain);
      scale_values(curve, scale);
      const auto keys = std::exchange(curve.points, {});
      CurveDrawing drawing(band.curve, channel.gain * scale);
      drawing.append(keys, curve.points);
      drawing.finish(curve.points);
      points_ += curve.points.size();
      if (points_ > kMostPoints)
        return "too many keyframes";
      curves.push_back(std::move(curve));
    }
    join_effects(curves);
    std::ranges::move(curves, std::back_inserter(curves_));
    return nullptr;
  }

  void leave_out(bool is_there, const char *what) {
    if (is_there && std::ranges::find(left_out_, what) == left_out_.end())
      left_out_.push_back(what);
  }

  const char *end_effect() {
    if (effect_.type == EffectType::unknown)
      return "an effect of no known type";
    if (levels_.back() == Level::band)
      band_.effects.push_back(std::move(effect_));
    else // of a composite one, no curve is known
      perception_.library[effect_.id] =
          effect_.type == EffectType::basis ? std::move(effect_.keys) : std::vector<CurvePoint>();
    return nullptr;
  }

  const char *end_keyframe() {
    auto &points = effect_.keys;
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
  CurvePoint keyframe_;
  double keyframe_tick_ = 0;

  double level_ = 0;
  std::size_t channels_ = 0;
  std::size_t bands_ = 0; // the most of one channel
  bool has_version_ = false;
  bool has_force_ = false;
  double timescale_ = 0;
  std::size_t keyframes_ = 0;
  std::size_t points_ = 0; // of the curves
  std::vector<ChannelCurve> curves_;
  std::vector<const char *> left_out_;
};

// ---- samples ------------------------------------------------------------------------------------

const char *make_samples(std::vector<ChannelCurve> &curves, double timescale,
                         std::vector<TrackSample> &samples) {
  if (curves.empty())
    return nullptr;
  std::sort(curves.begin(), curves.end(), begins_before);
  const auto last = std::max_element(curves.begin(), curves.end(),
                                     [](const ChannelCurve &a, const ChannelCurve &b) {
                                       return a.points.back().tick < b.points.back().tick;
                                     });
  const std::int64_t silence = last->points.back().tick + 1;
  const auto rest = static_cast<std::int64_t>(std::ceil(timescale * kFinalSilence));
  // Piece by piece: only so many points are summed at once, and a track may last for hours.
  constexpr std::size_t kPiece = kMostForcePoints / 4; // points; a curve adds some at its ends
  std::vector<std::int64_t> ticks;
  for (const auto &curve : curves)
    for (const auto &point : curve.points)
      ticks.push_back(point.tick);
  std::sort(ticks.begin(), ticks.end());
  ForceSampler sampler;
  std::int64_t begin = ticks.front();
  for (std::size_t at = kPiece; at <= ticks.size(); at += kPiece) {
    const std::int64_t end = at < ticks.size() ? ticks[at] : begin;
    if (end == begin)
      continue;
    if (const char *wrong = sampler.append(curves, begin, end, {.timescale = timescale}, samples))
      return wrong;
    begin = end;
  }
  return sampler.append(curves, begin, silence + rest, {.timescale = timescale}, samples);
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
  track.unsupported = handler.left_out();
  if (wrong) {
    track = {};
    track.error = wrong;
    track.offset = text.size();
  }
  return track;
}

} // namespace haptic
