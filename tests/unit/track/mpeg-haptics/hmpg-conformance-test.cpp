// SPDX-License-Identifier: LGPL-2.1-or-later
// Streams that others write, against a plain synthesis: newtons are the sum over the effects of
// amplitude * gain * 10^exponent along the direction, on the curve through the keyframes.
#include "mpeg-haptics/bits.hpp"
#include "mpeg-haptics/force-curve.hpp"
#include "mpeg-haptics/hjif.hpp"
#include "mpeg-haptics/hmpg-track.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <string>
#include <tuple>

namespace hmpg_conformance_test {

using haptic::BitWriter;
using haptic::CurveType;
using haptic::HmpgExperience;
using haptic::TrackSample;
using Bytes = std::vector<std::uint8_t>;

constexpr int kTicks = 1000; // of a second
constexpr int kEnd = 4 * kTicks;

// ---- content ------------------------------------------------------------------------------------

struct Keyframe {
  int tick; // from the beginning of the track
  double amplitude;
};

struct Effect {
  int channel;
  std::vector<Keyframe> keyframes;           // of a reference its beginning alone
  std::optional<std::size_t> reference = {}; // to an effect of the library
};

struct Content {
  HmpgExperience experience;
  std::vector<Effect> effects;                     // the index is the id
  std::vector<std::vector<Keyframe>> library = {}; // the index is the id
};
constexpr std::size_t kLibrary = 60000; // added to the ids of the library in .hmpg

// The nearest amplitude that 8 bits hold.
double coded(double amplitude) {
  const double code = std::round((amplitude + 1) / 2 * 255);
  return code == 127 || code == 128 ? 0 : code / 255 * 2 - 1;
}

HmpgExperience two_channels(double gain_x = 1, double gain_y = 1) {
  HmpgExperience e = haptic::track_experience("2026-01-01");
  e.timescale = kTicks;
  e.channels[0].gain = gain_x;
  e.channels[1].gain = gain_y;
  return e;
}

// A keyframe every `every` ticks on a slow wave.
Effect wave(int channel, int begin, int end, int every, double phase) {
  Effect effect{channel, {}};
  for (int tick = begin; tick <= end; tick += every)
    effect.keyframes.push_back({tick, coded(0.55 * std::sin(tick * 0.004 + phase))});
  return effect;
}

Content aligned() {
  return {two_channels(), {wave(0, 0, 3500, 25, 1), wave(1, 0, 3500, 25, 2)}};
}
Content unaligned() {
  return {two_channels(), {wave(0, 0, 3500, 50, 1), wave(1, 20, 3400, 70, 2)}};
}
Content overlapping() {
  return {two_channels(0.5, 1),
          {wave(0, 0, 2000, 40, 1), wave(0, 1010, 3400, 40, 0), wave(1, 500, 3000, 90, 2),
           wave(1, 2100, 2700, 30, 3)}};
}
Content sparse() {
  return {two_channels(), {wave(0, 10, 3210, 800, 1), wave(1, 300, 3000, 900, 2)}};
}
Content touching() {
  Content content{two_channels(), {}};
  for (int begin = 0; begin < 3000; begin += 100) {
    content.effects.push_back(wave(0, begin, begin + 100, 20, 1));
    content.effects.push_back(wave(1, begin, begin + 100, 50, 2));
  }
  return content;
}
Content stepping() { // each effect begins with another force than that of the one before
  Content content{two_channels(), {}};
  for (int i = 0; i < 20; ++i)
    content.effects.push_back(
        {i % 2, {{i * 150, coded(0.1 * (i % 7))}, {i * 150 + 170, coded(0.6 - 0.1 * (i % 5))}}});
  return content;
}
Content constant() { // two keyframes hold a force for seconds
  return {
      two_channels(),
      {{0, {{0, coded(0.5)}, {1000, coded(0.5)}}}, {1, {{1500, coded(0.3)}, {3400, coded(0.3)}}}}};
}
Content library() { // some of its effects last longer than a unit, or overlap
  Content content{two_channels(), {wave(0, 500, 2200, 70, 1)}};
  content.library = {wave(0, 0, 400, 40, 1).keyframes, wave(0, 0, 90, 45, 2).keyframes};
  for (const int begin : {30, 700, 1130, 2400, 2801})
    content.effects.push_back({begin % 2, {{begin, 0}}, 0});
  for (const int begin : {120, 860, 951, 3000})
    content.effects.push_back({begin % 2, {{begin, 0}}, 1});
  return content;
}

void keep_gains(Content &) {}
void large_gain(Content &content) { // at full scale 25 N, and -0.8 N
  content.experience.channels[0].gain = 2.5;
  content.experience.channels[1].gain = -0.08;
  content.experience.perceptions[0].exponent = 1;
  for (auto &effect : content.effects)
    if (effect.channel == 0)
      for (auto &keyframe : effect.keyframes)
        keyframe.amplitude = coded(keyframe.amplitude / 20);
}
void too_strong(Content &content) {
  content.experience.channels[0].gain *= 2.5;
}

// ---- the forms of the standard ------------------------------------------------------------------

void put_packet(BitWriter &payload, unsigned type, const BitWriter &content) {
  payload.put(type, 6);
  payload.put(content.bytes().size(), 17);
  payload.put(0, 1);
  for (const auto byte : content.bytes())
    payload.put(byte, 8);
}

Bytes unit_of(unsigned type, bool dependent, int duration, const Bytes &payload) {
  BitWriter unit;
  unit.put(type, 6);
  unit.put(dependent ? 1 : 0, 2);
  unit.put(0, 4);
  unit.put(static_cast<unsigned>(duration), 24);
  unit.put(payload.size(), 32);
  unit.put(0, 4);
  Bytes bytes = unit.bytes();
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

// When a unit is marked independent: if every packet begins with the first keyframe of its effect,
// or, as the reference encoder does, if one effect begins in it though others go on.
enum class Independent { when_all_begin, when_one_begins };

// A unit with the keyframes of its time; a packet for each effect.
Bytes unit_at(const Content &content, int begin, int duration,
              Independent independent = Independent::when_all_begin) {
  BitWriter payload;
  bool one_begins = false;
  bool one_continues = false;
  for (std::size_t id = 0; id < content.effects.size(); ++id) {
    const Effect &effect = content.effects[id];
    const int start = effect.keyframes.front().tick;
    std::vector<Keyframe> keyframes;
    std::ranges::copy_if(effect.keyframes, std::back_inserter(keyframes), [&](const auto &k) {
      return k.tick >= begin && k.tick < begin + duration;
    });
    if (keyframes.empty())
      continue;
    const bool continues = keyframes.front().tick != start;
    one_begins = one_begins || !continues;
    one_continues = one_continues || continues;
    BitWriter data;
    data.put(continues ? 1 : 0, 1);
    data.put(0, 8); // perception
    data.put(static_cast<unsigned>(effect.channel), 16);
    data.put(static_cast<unsigned>(effect.channel), 8); // band
    data.put(1, 16);                                    // effects
    data.put(effect.reference ? kLibrary + *effect.reference : id, 16);
    data.put(effect.reference ? 1 : 0, 2);
    data.put(static_cast<std::uint32_t>(start - begin), 25);
    if (effect.reference) {
      put_packet(payload, 5, data);
      continue;
    }
    data.put(0, 1);
    data.put(keyframes.size(), 16);
    for (const auto &keyframe : keyframes) {
      data.put(static_cast<unsigned>(std::lround((keyframe.amplitude + 1) / 2 * 255)), 8);
      data.put(static_cast<unsigned>(keyframe.tick - start), 16);
    }
    put_packet(payload, 5, data);
  }
  const bool dependent =
      independent == Independent::when_all_begin ? one_continues : one_continues && !one_begins;
  return unit_of(payload.bytes().empty() ? 3 : 1, dependent, duration, payload.bytes());
}

// The initialization unit with the library behind it.
Bytes first_unit(const Content &content) {
  const Bytes unit = haptic::write_initialization_unit(content.experience);
  BitWriter payload;
  for (std::size_t i = haptic::kUnitHeaderSize; i < unit.size(); ++i)
    payload.put(unit[i], 8);
  BitWriter library;
  library.put(0, 8); // perception
  library.put(content.library.size(), 16);
  for (std::size_t id = 0; id < content.library.size(); ++id) {
    library.put(kLibrary + id, 16);
    library.put(0, 25 + 16 + 4 + 2); // position, phase, base signal, basis
    library.put(content.library[id].size(), 16);
    for (const auto &keyframe : content.library[id]) {
      library.put(3, 3); // a position and an amplitude
      library.put(static_cast<unsigned>(keyframe.tick), 16);
      library.put(static_cast<unsigned>(std::lround((keyframe.amplitude + 1) / 2 * 255)), 8);
    }
    library.put(0, 16); // composed of nothing
  }
  if (!content.library.empty())
    put_packet(payload, 6, library);
  return unit_of(0, false, 0, payload.bytes());
}

std::vector<TrackSample> read_units(const Content &content, int duration, bool with_times,
                                    Independent independent = Independent::when_all_begin) {
  haptic::HmpgDecoder decoder;
  std::vector<TrackSample> samples;
  const auto append = [&](const haptic::HmpgDecoder::Result &result) {
    samples.insert(samples.end(), result.samples.begin(), result.samples.end());
  };
  append(decoder.push(first_unit(content), haptic::kNoTime));
  for (int begin = 0; begin < kEnd; begin += duration)
    append(decoder.push(unit_at(content, begin, duration, independent),
                        with_times ? haptic::ns_of(begin, kTicks) : haptic::kNoTime));
  append(decoder.finish());
  return samples;
}

std::string json_of(const std::vector<Keyframe> &keyframes, int start) {
  char amplitude[32];
  std::string text = R"("keyframes":[)";
  for (const auto &keyframe : keyframes) {
    std::snprintf(amplitude, sizeof amplitude, "%.12f", keyframe.amplitude);
    text += std::string(text.back() == '[' ? "" : ",") + R"({"relative_position":)" +
            std::to_string(keyframe.tick - start) + R"(,"amplitude_modulation":)" + amplitude + "}";
  }
  return text + "]}";
}

std::string json_of(const Effect &effect) {
  const int start = effect.keyframes.front().tick;
  const std::string place = R"("position":)" + std::to_string(start);
  if (effect.reference)
    return R"({"effect_type":"Reference","id":)" + std::to_string(*effect.reference) + "," + place +
           "}";
  return R"({"effect_type":"Basis",)" + place + "," + json_of(effect.keyframes, start);
}

// The library comes behind the channels that refer to it.
std::string hjif_of(const Content &content) {
  constexpr const char *kNames[] = {"Unknown", "Cubic", "Linear", "Akima", "Bezier", "Bspline"};
  const auto &e = content.experience;
  std::string text = R"({"version":"2023","timescale":1000,"perceptions":[{"perception_modality":)"
                     R"("Force","perception_unit_exponent":)" +
                     std::to_string(e.perceptions[0].exponent) + R"(,"channels":[)";
  for (const auto &channel : e.channels) {
    text += std::string(channel.id == 0 ? "" : ",") + R"({"gain":)" + std::to_string(channel.gain) +
            R"(,"bands":[{"band_type":"Curve","effects":[)";
    for (const auto &effect : content.effects)
      if (effect.channel == channel.id)
        text += (text.back() == '[' ? "" : ",") + json_of(effect);
    text += R"(],"curve_type":")" +
            std::string(kNames[static_cast<std::size_t>(e.bands[channel.id].curve)]) + "\"}]";
    if (channel.direction)
      text += R"(,"direction":{"X":)" + std::to_string((*channel.direction)[0]) + R"(,"Y":)" +
              std::to_string((*channel.direction)[1]) + R"(,"Z":0})";
    text += "}";
  }
  text += R"(],"effect_library":[)";
  for (std::size_t id = 0; id < content.library.size(); ++id)
    text += (id == 0 ? "" : ",") + (R"({"id":)" + std::to_string(id)) +
            R"(,"effect_type":"Basis","position":0,)" + json_of(content.library[id], 0);
  return text + "]}]}";
}

// ---- synthesis ----------------------------------------------------------------------------------

struct Force {
  double x = 0;
  double y = 0;
};

// Akima's slopes at the keyframes (J. ACM 17:589): the mean of the slopes on both sides, each with
// the weight of the bend on the other side; two more slopes at each end continue a parabola.
std::vector<double> akima_slopes(const std::vector<Keyframe> &k) {
  std::vector<double> m = {0, 0};
  for (std::size_t i = 1; i < k.size(); ++i)
    m.push_back((k[i].amplitude - k[i - 1].amplitude) / (k[i].tick - k[i - 1].tick));
  const std::size_t last = m.size() - 1;
  const double second = m[std::min(last, std::size_t{3})];
  const double last_but_one = m[std::max<std::size_t>(last - 1, 2)];
  m[1] = 2 * m[2] - second;
  m[0] = 3 * m[2] - 2 * second;
  m.push_back(2 * m[last] - last_but_one);
  m.push_back(3 * m[last] - 2 * last_but_one);
  std::vector<double> slopes;
  for (std::size_t i = 0; i < k.size(); ++i) {
    const double left = std::abs(m[i + 1] - m[i]);
    const double right = std::abs(m[i + 3] - m[i + 2]);
    slopes.push_back(left + right > 1e-12 ? (right * m[i + 1] + left * m[i + 2]) / (left + right)
                                          : m[i + 1]);
  }
  return slopes;
}

// Hermite's polynomial. The slopes of cubic curves are 0.
double amplitude_at(const std::vector<Keyframe> &k, CurveType curve,
                    const std::vector<double> &slopes, int tick) {
  for (std::size_t i = 1; i < k.size(); ++i) {
    if (tick < k[i - 1].tick || tick > k[i].tick)
      continue;
    const double length = k[i].tick - k[i - 1].tick;
    const double u = (tick - k[i - 1].tick) / length;
    const double v = 1 - u;
    if (curve == CurveType::linear || curve == CurveType::bezier)
      return v * k[i - 1].amplitude + u * k[i].amplitude;
    return (1 + 2 * u) * v * v * k[i - 1].amplitude + u * v * v * length * slopes[i - 1] +
           u * u * (3 - 2 * u) * k[i].amplitude - u * u * v * length * slopes[i];
  }
  return 0;
}

// Adds what the standard's text gives for an effect. Where the next effect of a band begins at the
// last tick of an effect, it alone counts.
void add_expected(const Content &content, const Effect &effect, std::vector<Force> &forces) {
  const auto index = static_cast<std::size_t>(effect.channel);
  const auto &channel = content.experience.channels[index];
  if (!channel.direction)
    return;
  const auto &keyframes = effect.reference ? content.library[*effect.reference] : effect.keyframes;
  const int begin = effect.reference ? effect.keyframes.front().tick : 0;
  const int last = begin + keyframes.back().tick;
  const CurveType curve = content.experience.bands[index].curve;
  const auto slopes =
      curve == CurveType::akima ? akima_slopes(keyframes) : std::vector<double>(keyframes.size());
  const bool is_followed = std::ranges::any_of(content.effects, [&](const Effect &next) {
    return next.channel == effect.channel && next.keyframes.front().tick == last;
  });
  const double scale =
      channel.gain * std::pow(10, content.experience.perceptions[0].exponent) / 127;
  for (int tick = begin + keyframes.front().tick; tick <= (is_followed ? last - 1 : last); ++tick) {
    const double value = scale * amplitude_at(keyframes, curve, slopes, tick - begin);
    forces[static_cast<std::size_t>(tick)].x += value * (*channel.direction)[0];
    forces[static_cast<std::size_t>(tick)].y += value * (*channel.direction)[1];
  }
}

// hmpg.md: a force of 98 % and more is one of 98 %.
std::vector<Force> expected(const Content &content) {
  std::vector<Force> forces(kEnd);
  for (const auto &effect : content.effects)
    add_expected(content, effect, forces);
  for (auto &force : forces) {
    const double cut = std::min(1.0, 0.98 / std::max(1e-9, std::hypot(force.x, force.y)));
    force = {force.x * cut, force.y * cut};
  }
  return forces;
}

// What the samples give: straight lines between felt ones, nothing from a silent one on, nor when
// no sample follows for longer than safety-chain.hpp's stale_after().
Force felt_at(const std::vector<TrackSample> &samples, int tick) {
  const std::uint64_t time = haptic::ns_of(tick, kTicks);
  const auto after = std::ranges::upper_bound(samples, time, {}, &TrackSample::time);
  if (after == samples.begin() || (after - 1)->motion.confidence == 0)
    return {};
  const std::uint64_t longest =
      std::clamp(3 * (after - 1)->motion.interval, haptic::kSecond / 10, 2 * haptic::kSecond);
  if (time - (after - 1)->time > longest)
    return {};
  const auto a = haptic::force_of_motion((after - 1)->motion);
  if (after == samples.end() || after->motion.confidence == 0)
    return {a.x, a.y};
  const auto b = haptic::force_of_motion(after->motion);
  const double part = static_cast<double>(time - (after - 1)->time) /
                      static_cast<double>(after->time - (after - 1)->time);
  return {std::lerp(a.x, b.x, part), std::lerp(a.y, b.y, part)};
}

std::vector<Force> felt(const std::vector<TrackSample> &samples) {
  std::vector<Force> forces;
  for (int tick = 0; tick < kEnd; ++tick)
    forces.push_back(felt_at(samples, tick));
  return forces;
}

// Rms of the difference over that of the force, %.
double rms_error(const std::vector<Force> &got, const std::vector<Force> &wanted) {
  double error = 0;
  double power = 0;
  for (std::size_t tick = 0; tick < kEnd; ++tick) {
    error += std::pow(got[tick].x - wanted[tick].x, 2) + std::pow(got[tick].y - wanted[tick].y, 2);
    power += std::pow(wanted[tick].x, 2) + std::pow(wanted[tick].y, 2);
  }
  return 100 * std::sqrt(error / power);
}

// ---- matrix -------------------------------------------------------------------------------------

template <typename Value>
struct Choice {
  const char *name;
  Value value;
};
constexpr Choice<Content (*)()> kArrangements[] = {
    {"Aligned", aligned},   {"Unaligned", unaligned}, {"Overlapping", overlapping},
    {"Sparse", sparse},     {"Touching", touching},   {"Stepping", stepping},
    {"Constant", constant}, {"Library", library}};
constexpr Choice<CurveType> kCurves[] = {{"Linear", CurveType::linear},
                                         {"Cubic", CurveType::cubic},
                                         {"Akima", CurveType::akima},
                                         {"Bezier", CurveType::bezier}}; // as straight lines
constexpr Choice<void (*)(Content &)> kGains[] = {
    {"", keep_gains}, {"LargeGain", large_gain}, {"TooStrong", too_strong}};
constexpr Choice<bool> kDirections[] = {{"", true}, {"NoDirection", false}};

using Cell =
    std::tuple<Choice<Content (*)()>, Choice<CurveType>, Choice<void (*)(Content &)>, Choice<bool>>;

Content content_of(const Cell &cell) {
  const auto &[arrangement, curve, gains, has_direction] = cell;
  Content content = arrangement.value();
  for (auto &band : content.experience.bands)
    band.curve = curve.value;
  gains.value(content);
  if (!has_direction.value)
    content.experience.channels[1].direction.reset();
  return content;
}

class HmpgConformance : public testing::TestWithParam<Cell> {};

TEST_P(HmpgConformance, TheForceIsThatOfTheStandard) {
  const Content content = content_of(GetParam());
  const auto wanted = expected(content);
  // A cell whose amplitudes all round to zero would test nothing.
  const auto is_there = [&](double Force::*axis) {
    return std::ranges::any_of(wanted, [&](const Force &f) { return std::abs(f.*axis) > 0.15; });
  };
  EXPECT_TRUE(is_there(&Force::x));
  EXPECT_EQ(is_there(&Force::y), content.experience.channels[1].direction.has_value());
  const CurveType curve = content.experience.bands[0].curve;
  const bool is_straight = curve != CurveType::cubic && curve != CurveType::akima;
  // Only .hmpg may have gains below 0.
  const bool has_json = std::ranges::all_of(content.experience.channels,
                                            [](const auto &channel) { return channel.gain >= 0; });
  const auto json = haptic::read_hjif(hjif_of(content));
  ASSERT_EQ(json.error, has_json ? "" : "a negative gain");
  const auto of_json = has_json ? felt(json.samples) : wanted;
  EXPECT_LE(rms_error(of_json, wanted), 1) << "hjif";
  for (const int duration : {33, 100, 1000})
    for (const bool with_times : {false, true}) {
      const auto samples = read_units(content, duration, with_times);
      EXPECT_TRUE(std::ranges::is_sorted(samples, {}, &TrackSample::time));
      const auto of_units = felt(samples);
      EXPECT_LE(rms_error(of_units, wanted), 1) << "hmpg of " << duration;
      if (has_json) {
        EXPECT_LE(rms_error(of_units, of_json), is_straight ? 0.01 : 0.05)
            << "hmpg of " << duration << " against hjif";
      }
    }
}

INSTANTIATE_TEST_SUITE_P(, HmpgConformance,
                         testing::Combine(testing::ValuesIn(kArrangements),
                                          testing::ValuesIn(kCurves), testing::ValuesIn(kGains),
                                          testing::ValuesIn(kDirections)),
                         [](const auto &test) {
                           return std::string(std::get<0>(test.param).name) +
                                  std::get<1>(test.param).name + std::get<2>(test.param).name +
                                  std::get<3>(test.param).name;
                         });

// Up to four effects in each band, which overlap, meet and pause as they come.
Content random_content(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto number = [&](int least, int most) {
    return std::uniform_int_distribution<int>(least, most)(random);
  };
  Content content{two_channels(), {}};
  for (auto &band : content.experience.bands)
    band.curve = number(0, 1) == 0 ? CurveType::linear : CurveType::cubic;
  const int count = number(2, 8);
  for (int i = 0; i < count; ++i) {
    Effect effect{i % 2, {}};
    int tick = number(0, 2400);
    for (int keys = number(2, 40); keys > 0 && tick < kEnd - 400; --keys) {
      effect.keyframes.push_back({tick, coded(0.01 * number(-45, 45))});
      tick += number(1, 144);
    }
    content.effects.push_back(std::move(effect));
  }
  return content;
}

// Whether an effect seems to be over though it goes on: in the unit in which it begins it has a
// keyframe at the last tick, and none in the unit behind.
bool seems_over(const Content &content, int duration) {
  return std::ranges::any_of(content.effects, [&](const Effect &effect) {
    const auto &keys = effect.keyframes;
    const auto unit_of_key = [&](const Keyframe &key) { return key.tick / duration; };
    const auto next = std::ranges::find_if(
        keys, [&](const auto &key) { return unit_of_key(key) != unit_of_key(keys.front()); });
    return next != keys.end() && next - keys.begin() > 1 &&
           ((next - 1)->tick + 1) % duration == 0 &&
           unit_of_key(*next) > unit_of_key(keys.front()) + 1;
  });
}

TEST(HmpgRandom, EffectsGoOnInUnitsThatAreMarkedIndependent) {
  int wrong = 0;
  int unclear = 0;
  for (std::uint32_t seed = 1; seed <= 1000; ++seed) {
    const Content content = random_content(seed);
    const auto wanted = expected(content);
    const int duration = seed % 2 == 0 ? 100 : 330;
    if (seems_over(content, duration)) {
      ++unclear;
      continue;
    }
    const double error = rms_error(
        felt(read_units(content, duration, seed % 3 == 0, Independent::when_one_begins)), wanted);
    if (error > 1 && ++wrong <= 5)
      ADD_FAILURE() << "seed " << seed << ": " << error << " %";
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(unclear, 10) << "of 1000";
}

// Which of the two counts at their common tick is known when the first one goes on.
TEST(HmpgRandom, AnEffectMayBeginAtAKeyframeOfAnotherThatGoesOn) {
  for (const int begin : {150, 151}) {
    const Content content{two_channels(),
                          {{0, {{0, coded(0.3)}, {150, coded(0.4)}, {320, coded(0.3)}}},
                           {0, {{begin, coded(0.2)}, {260, coded(0.2)}}},
                           {1, {{0, coded(0.1)}, {500, coded(0.1)}}}}};
    for (const int duration : {33, 100, 330})
      for (const auto independent : {Independent::when_all_begin, Independent::when_one_begins})
        EXPECT_LE(
            rms_error(felt(read_units(content, duration, false, independent)), expected(content)),
            1)
            << begin << ", units of " << duration;
  }
}

TEST(HmpgUnsupported, WhatGivesNoForceIsNamedOnce) {
  Content content = unaligned();
  content.experience.channels[1].direction.reset();
  content.experience.bands[0].curve = CurveType::bspline;
  content.experience.perceptions.push_back({7, 6, 0, "vibrotactile"});
  content.experience.channels.push_back({9, 7, 1, {}, ""});
  content.experience.bands.push_back({9, 7, 9, haptic::BandType::vectorial});
  haptic::HmpgDecoder decoder;
  const auto unit = haptic::write_initialization_unit(content.experience);
  EXPECT_EQ(decoder.push(unit, haptic::kNoTime).unsupported,
            std::string(haptic::kOtherPerceptions) + ", " + haptic::kNoDirection + ", " +
                haptic::kOtherCurves);
  EXPECT_EQ(decoder.push(unit, haptic::kNoTime).unsupported, "");
  EXPECT_EQ(haptic::read_hjif(hjif_of(unaligned())).unsupported, "");
  content.experience.bands.pop_back();
  content.experience.channels.pop_back();
  EXPECT_EQ(haptic::read_hjif(hjif_of(content)).unsupported,
            std::string(haptic::kOtherCurves) + ", " + haptic::kNoDirection);
}

// Few bytes must not become gigabytes.
TEST(HmpgMemory, FarKeyframesOfManyEffectsGiveABoundedNumberOfSamples) {
  Content content{two_channels(), {}};
  content.experience.timescale = 20;
  for (int i = 0; i < 256; ++i)
    content.effects.push_back({0, {{i * 65535, coded(0.1)}, {i * 65535 + 65530, coded(0.2)}}});
  haptic::HmpgDecoder decoder;
  decoder.push(haptic::write_initialization_unit(content.experience), haptic::kNoTime);
  EXPECT_LE(decoder.push(unit_at(content, 0, (1 << 24) - 1), haptic::kNoTime).samples.size(),
            70'000U);
  EXPECT_LE(haptic::read_hjif(hjif_of(content)).samples.size(), 70'000U);
}

TEST(HmpgMemory, KeyframesInTheFutureAreRefusedOnceThereAreTooMany) {
  constexpr int kKeyframes = 40'000;
  for (const bool dependent : {false, true}) { // joined by touching, by id
    haptic::HmpgDecoder decoder;
    decoder.push(haptic::write_initialization_unit(two_channels()), haptic::kNoTime);
    std::string problem;
    for (int unit = 0; unit < 4; ++unit) {
      haptic::HmpgCurve effect;
      for (int i = 0; i <= kKeyframes; ++i)
        effect.keyframes.push_back({1'000'000 + unit * (kKeyframes - 1) + i, 200});
      Bytes bytes = haptic::write_temporal_unit(1, {{effect}});
      bytes[0] = static_cast<std::uint8_t>(bytes[0] | (dependent ? 1 : 0));
      EXPECT_EQ(problem, "") << unit;
      problem = decoder.push(bytes, haptic::kNoTime).problem;
    }
    EXPECT_EQ(problem, "too many keyframes at once");
  }
}

// Some bytes name keyframes of which there may be tens of thousands. Copied each time, they would
// take a minute.
TEST(HmpgMemory, ManyReferencesToALongEffectAreRefusedWithoutCopyingIt) {
  constexpr int kReferences = 4000;
  Content content{two_channels(), {}};
  content.library = {std::vector<Keyframe>(37'000, Keyframe{0, coded(0.5)})};
  haptic::HmpgDecoder decoder;
  EXPECT_EQ(decoder.push(first_unit(content), haptic::kNoTime).problem, "");
  BitWriter data;
  data.put(0, 1 + 8 + 16 + 8); // random access, perception, channel, band
  data.put(kReferences, 16);
  for (int i = 0; i < kReferences; ++i) {
    data.put(kLibrary, 16);
    data.put(1, 2);
    data.put(0, 25);
  }
  BitWriter payload;
  put_packet(payload, 5, data);
  EXPECT_EQ(decoder.push(unit_of(1, false, 100, payload.bytes()), haptic::kNoTime).problem,
            "too many keyframes at once");
  put_packet(payload, 5, data);
  EXPECT_EQ(decoder.push(unit_of(1, false, 100, payload.bytes()), haptic::kNoTime).problem,
            "too many effects at once");
}

// While one effect waits for its next keyframe, the samples of the other are held back.
TEST(HmpgDiscontinuity, WhatWasHeldBackComesBeforeTheUnitBehindTheJump) {
  const Content content{two_channels(), {wave(0, 0, 3000, 2000, 1), wave(1, 0, 3500, 25, 2)}};
  haptic::HmpgDecoder decoder;
  decoder.push(haptic::write_initialization_unit(content.experience), haptic::kNoTime);
  for (int begin = 0; begin < 1000; begin += 100)
    decoder.push(unit_at(content, begin, 100), haptic::ns_of(begin, kTicks));
  const auto samples = decoder.push(unit_at(content, 1000, 100), 11 * haptic::kSecond).samples;
  EXPECT_TRUE(std::ranges::is_sorted(samples, {}, &TrackSample::time));
  const auto behind =
      std::ranges::lower_bound(samples, 11 * haptic::kSecond, {}, &TrackSample::time);
  ASSERT_GT(behind - samples.begin(), 30);
  EXPECT_NE(behind, samples.end());
  EXPECT_EQ((behind - 1)->time, haptic::ns_of(975, kTicks));
  EXPECT_GT((behind - 1)->motion.confidence, 0);
}

// A live source has no time to wait for an effect that is over.
TEST(HmpgLive, SamplesAreHeldBackForAQuarterOfASecondAtMost) {
  const Content content{two_channels(), {wave(0, 0, 60, 20, 1), wave(1, 0, 3500, 20, 2)}};
  haptic::HmpgDecoder decoder;
  decoder.set_live(true);
  decoder.push(haptic::write_initialization_unit(content.experience), haptic::kNoTime);
  std::uint64_t newest = 0;
  for (int begin = 0; begin < 3500; begin += 33) {
    for (const auto &sample :
         decoder.push(unit_at(content, begin, 33), haptic::ns_of(begin, kTicks)).samples)
      newest = sample.time;
    EXPECT_GE(newest + haptic::kSecond * 3 / 10, haptic::ns_of(begin + 33, kTicks)) << begin;
  }
}

} // namespace hmpg_conformance_test
