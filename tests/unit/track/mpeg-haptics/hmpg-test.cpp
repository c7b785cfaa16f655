// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/force-curve.hpp"
#include "mpeg-haptics/hjif.hpp"
#include "mpeg-haptics/hmpg-rtp.hpp"
#include "mpeg-haptics/hmpg-track.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <numbers>
#include <set>
#include <span>

namespace hmpg_test {

using haptic::CodedUnit;
using haptic::HmpgCurve;
using haptic::HmpgDecoder;
using haptic::HmpgEncoder;
using haptic::HmpgExperience;
using haptic::MotionSample;
using haptic::read_unit;
using haptic::TrackSample;
using haptic::UnitType;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t kMs = 1'000'000;
constexpr std::uint64_t kFrame = 33'333'333;
constexpr char kDate[] = "2026-01-01";

MotionSample motion(double x, double y, double confidence = 1) {
  MotionSample s;
  s.velocity_x = static_cast<float>(x);
  s.velocity_y = static_cast<float>(y);
  s.confidence = static_cast<float>(confidence);
  s.frame_width = 352;
  s.frame_height = 288;
  s.interval = kFrame;
  return s;
}

HmpgCurve curve(std::uint16_t id, std::vector<haptic::HmpgKeyframe> keyframes) {
  const std::int32_t begin = keyframes.empty() ? 0 : keyframes.front().position;
  return {0, id, static_cast<std::uint8_t>(id), id, std::move(keyframes), {}, begin};
}

void append(std::vector<CodedUnit> &units, std::vector<CodedUnit> more) {
  std::move(more.begin(), more.end(), std::back_inserter(units));
}

// ---- bytes --------------------------------------------------------------------------------------

TEST(ForceCurve, ScalesTheVelocityToTheReferenceWidth) {
  haptic::MotionSample sample;
  sample.frame_width = 352;
  sample.frame_height = 288;
  sample.velocity_x = 30;
  sample.velocity_y = -40;
  sample.confidence = 1;
  const auto narrow = haptic::force_of_motion(sample);
  EXPECT_NEAR(std::hypot(narrow.x, narrow.y), 2 / std::numbers::pi * std::atan(0.5), 1e-12);
  EXPECT_GT(narrow.y, 0) << "up is positive";
  sample.frame_width = 1920;
  sample.velocity_x *= 1920 / 352.0F;
  sample.velocity_y *= 1920 / 352.0F;
  const auto wide = haptic::force_of_motion(sample);
  EXPECT_NEAR(wide.x, narrow.x, 1e-6);
  EXPECT_NEAR(wide.y, narrow.y, 1e-6);
}

TEST(Hmpg, ASilentUnitIsItsHeader) {
  // type 3 in 6 bits, 2 + 4 of zero, 24 of duration, 32 of length, 4 of zero
  const Bytes unit = haptic::write_silent_unit(0x123456);
  EXPECT_EQ(unit, (Bytes{0x0C, 0x01, 0x23, 0x45, 0x60, 0, 0, 0, 0}));
}

TEST(Hmpg, ATemporalUnitIsLaidOutToTheBit) {
  const std::vector<HmpgCurve> curves = {curve(1, {{0, 255}, {267, 0}})};
  const Bytes unit = haptic::write_temporal_unit(267, curves);
  const Bytes expected = {
      // unit: type 1, independent, layer 0, duration 267, length 23
      0x04, 0x00, 0x00, 0x10, 0xB0, 0x00, 0x00, 0x01, 0x70,
      // packet: type 5, length 20, reserved 0
      0x14, 0x00, 0x28,
      // random access 0 | perception 0 | channel 1 | band 1 | effects 1 | id 1 | type 0 |
      // position 0 | semantics 0 | keyframes 2 | 255 at 0 | 0 at 267
      0x00, 0x00, 0x00, 0x80, 0x80, 0x00, 0x80, 0x00, 0x80, 0x00, 0x00, 0x00, 0x00, 0x17, 0xF8,
      0x00, 0x00, 0x00, 0x08, 0x58};
  EXPECT_EQ(unit, expected);
}

TEST(Hmpg, AmplitudesGoToTheNearestCodeAndZeroComesBackAsZero) {
  EXPECT_EQ(haptic::amplitude_of_code(haptic::code_of_amplitude(0)), 0);
  for (double amplitude = -1; amplitude <= 1; amplitude += 1e-3)
    EXPECT_NEAR(haptic::amplitude_of_code(haptic::code_of_amplitude(amplitude)), amplitude,
                std::abs(amplitude) < 2 / 255.0 ? 2 / 255.0 : 1 / 255.0 + 1e-9);
  EXPECT_EQ(haptic::code_of_amplitude(-7), 0);
  EXPECT_EQ(haptic::code_of_amplitude(7), 255);
}

TEST(Hmpg, AnExperienceComesBack) {
  HmpgExperience e = haptic::track_experience(kDate);
  e.time = 123456789;
  e.nominal = 800;
  const auto unit = read_unit(haptic::write_initialization_unit(e), nullptr);
  ASSERT_FALSE(unit.error) << unit.error->what;
  ASSERT_TRUE(unit.experience);
  for (auto &channel : unit.experience->channels) {
    EXPECT_NEAR(channel.gain, 1, 1e-5);
  }
  HmpgExperience read = *unit.experience;
  for (auto &channel : read.channels)
    channel.gain = 1;
  EXPECT_EQ(read, e);
}

TEST(Hmpg, CurvesComeBack) {
  const HmpgExperience e = haptic::track_experience(kDate);
  const std::vector<HmpgCurve> curves = {curve(0, {{0, 1}, {100, 2}, {65535, 3}}),
                                         curve(1, {{-5, 200}, {7, 100}})};
  const auto unit = read_unit(haptic::write_temporal_unit(800, curves), &e);
  ASSERT_FALSE(unit.error) << unit.error->what;
  EXPECT_EQ(unit.header.duration, 800U);
  EXPECT_EQ(unit.curves, curves);
}

std::vector<Bytes> one_of_each() {
  const HmpgExperience e = haptic::track_experience(kDate);
  const std::vector<HmpgCurve> curves = {curve(0, {{0, 1}, {100, 2}}), curve(1, {{0, 3}})};
  return {haptic::write_initialization_unit(e), haptic::write_temporal_unit(800, curves),
          haptic::write_silent_unit(800)};
}

TEST(Hmpg, EveryTruncationIsRefusedWithItsPlace) {
  const HmpgExperience e = haptic::track_experience(kDate);
  for (const auto &whole : one_of_each())
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto unit = read_unit(std::span(whole).first(size), &e);
      ASSERT_TRUE(unit.error) << size;
      EXPECT_LE(unit.error->offset, size);
      EXPECT_TRUE(unit.curves.empty());
      EXPECT_FALSE(unit.experience);
    }
}

TEST(Hmpg, ACutInsideIsRefusedEvenWhenTheLengthsAgree) {
  const HmpgExperience e = haptic::track_experience(kDate);
  for (auto whole : one_of_each()) {
    if (whole.size() == haptic::kUnitHeaderSize)
      continue;
    // The unit's own length follows the cut; its last packet does not.
    for (std::size_t cut = 1; cut < whole.size() - haptic::kUnitHeaderSize; ++cut) {
      Bytes part(whole.begin(), whole.end() - static_cast<std::ptrdiff_t>(cut));
      const auto length = static_cast<std::uint32_t>(part.size() - haptic::kUnitHeaderSize);
      part[4] = static_cast<std::uint8_t>((part[4] & 0xF0U) | length >> 28);
      for (unsigned i = 0; i < 4; ++i)
        part[5 + i] = static_cast<std::uint8_t>(length << 4 >> (24 - 8 * i));
      const auto unit = read_unit(part, &e);
      // Whole packets may be missing at the end: then what is left must still be sound.
      if (!unit.error) {
        EXPECT_TRUE(unit.header.type == UnitType::temporal || unit.experience);
      }
    }
  }
}

TEST(Hmpg, ImpossibleFieldsAreRefusedWhereTheyStand) {
  const HmpgExperience e = haptic::track_experience(kDate);
  const auto error_at = [&](Bytes bytes, std::size_t at, std::uint8_t value) {
    bytes.at(at) = value;
    const auto unit = read_unit(bytes, &e);
    EXPECT_TRUE(unit.error) << "byte " << at;
    return unit.error ? unit.error->offset : std::size_t{999};
  };
  const auto units = one_of_each();
  EXPECT_EQ(error_at(units[2], 0, 0x10), 0U);   // unit type 4
  EXPECT_EQ(error_at(units[2], 0, 0x0E), 0U);   // sync 2
  EXPECT_EQ(error_at(units[2], 8, 0x01), 0U);   // reserved bits
  EXPECT_EQ(error_at(units[0], 0, 0x01), 0U);   // an initialization unit that depends
  EXPECT_EQ(error_at(units[1], 9, 0xFC), 9U);   // packet type 63
  EXPECT_EQ(error_at(units[1], 9, 0x04), 12U);  // metadata in a temporal unit
  EXPECT_GE(error_at(units[1], 12, 0x7F), 12U); // data of no perception
  EXPECT_GE(error_at(units[1], 11, 0xFE), 9U);  // a packet longer than the unit
  EXPECT_GE(error_at(units[0], 16, 0xFF), 12U); // a timescale beyond 48000
  Bytes silent = units[2];
  silent[3] = silent[2] = silent[4] = 0;
  EXPECT_TRUE(read_unit(silent, &e).error); // no duration
}

TEST(Hmpg, AnyBitErrorIsRefusedOrStaysWithinTheFormat) {
  const HmpgExperience e = haptic::track_experience(kDate);
  for (const auto &whole : one_of_each())
    for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
      Bytes bytes = whole;
      bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
      const auto unit = read_unit(bytes, &e);
      if (unit.error) {
        EXPECT_LE(unit.error->offset, bytes.size());
        continue;
      }
      EXPECT_LT(unit.header.duration, 1U << 24);
      for (const auto &c : unit.curves)
        for (const auto &keyframe : c.keyframes)
          EXPECT_LT(std::abs(keyframe.position), 1 << 25);
      if (unit.experience) {
        EXPECT_GT(unit.experience->timescale, 0U);
        EXPECT_LE(unit.experience->timescale, haptic::kHighestTimescale);
      }
    }
}

TEST(Hmpg, MayNotClaimMoreThanItHas) {
  Bytes unit = haptic::write_silent_unit(800);
  unit[4] = 0x0F; // a length of gigabytes
  EXPECT_FALSE(haptic::read_unit_header(unit));
}

// ---- tracks -------------------------------------------------------------------------------------

std::vector<TrackSample> decode(const std::vector<CodedUnit> &units, bool with_times) {
  HmpgDecoder decoder;
  std::vector<TrackSample> samples;
  for (const auto &unit : units) {
    const auto result = decoder.push(unit.bytes, with_times ? unit.time : haptic::kNoTime);
    EXPECT_EQ(result.problem, "");
    samples.insert(samples.end(), result.samples.begin(), result.samples.end());
  }
  return samples;
}

TEST(HmpgTrack, TheForceComesBackWithinHalfAStep) {
  for (const std::uint64_t unit : {33 * kMs, 100 * kMs, 1000 * kMs})
    for (const bool with_times : {false, true}) {
      HmpgEncoder encoder(unit, kDate);
      std::vector<CodedUnit> units;
      std::vector<TrackSample> sent;
      for (std::uint64_t i = 0; i < 300; ++i) {
        const double angle = static_cast<double>(i) / 20;
        const MotionSample s = motion(300 * std::sin(angle), 200 * std::cos(2 * angle));
        sent.push_back({s, 5'000 * kMs + i * kFrame, kFrame});
        append(units, encoder.push(s, sent.back().time, kFrame));
      }
      append(units, encoder.finish());
      const auto got = decode(units, with_times);
      ASSERT_EQ(got.size(), sent.size() + 1); // and the silence
      for (std::size_t i = 0; i < sent.size(); ++i) {
        const auto a = haptic::force_of_motion(sent[i].motion);
        const auto b = haptic::force_of_motion(got[i].motion);
        EXPECT_NEAR(a.x, b.x, 0.0040) << i;
        EXPECT_NEAR(a.y, b.y, 0.0040) << i;
        EXPECT_NEAR(static_cast<double>(sent[i].time), static_cast<double>(got[i].time), 0.13e6);
        EXPECT_EQ(got[i].motion.confidence, 1);
      }
      EXPECT_EQ(got.back().motion.confidence, 0);
    }
}

// The ticks at which two effects of a band are both present.
int shared_ticks(const std::vector<CodedUnit> &units) {
  const HmpgExperience e = haptic::track_experience(kDate);
  int shared = 0;
  std::int64_t begin = 0;
  std::array<std::int64_t, 2> ends = {-1, -1};
  for (const auto &coded : units) {
    const auto unit = read_unit(coded.bytes, &e);
    for (const auto &effect : unit.curves) {
      shared += begin + effect.keyframes.front().position <= ends.at(effect.band);
      ends.at(effect.band) = begin + effect.keyframes.back().position;
    }
    begin += unit.header.duration;
  }
  return shared;
}

TEST(HmpgTrack, NoTickHasTwoEffects) {
  for (const std::uint64_t unit : {33 * kMs, 100 * kMs, 1000 * kMs}) {
    HmpgEncoder encoder(unit, kDate);
    std::vector<CodedUnit> units;
    for (std::uint64_t i = 0; i < 300; ++i)
      append(units, encoder.push(motion(100, 0, i % 50 == 30 ? 0 : 1), i * kFrame, kFrame));
    append(units, encoder.finish());
    EXPECT_EQ(shared_ticks(units), 0);
  }
}

// A reader may take an id that comes again for the old effect.
TEST(HmpgTrack, NoEffectOfAnHourHasTheIdOfAnother) {
  constexpr std::uint64_t kHour = 3600 * 1000 / 33;
  HmpgEncoder encoder(33 * kMs, kDate);
  HmpgDecoder decoder;
  HmpgExperience experience;
  std::set<std::pair<std::uint8_t, std::uint16_t>> ids;
  std::uint64_t felt = 0;
  const auto read = [&](const std::vector<CodedUnit> &units) {
    for (const auto &coded : units) {
      auto unit = read_unit(coded.bytes, &experience);
      ASSERT_FALSE(unit.error) << unit.error->what;
      if (unit.experience)
        experience = *unit.experience;
      for (const auto &effect : unit.curves)
        EXPECT_TRUE(ids.insert({effect.band, effect.effect}).second);
      for (const auto &sample : decoder.push(coded.bytes, haptic::kNoTime).samples) {
        EXPECT_TRUE(sample.motion.confidence > 0 || coded.type == UnitType::silent);
        felt += sample.motion.confidence > 0;
      }
    }
  };
  for (std::uint64_t i = 0; i < kHour; ++i)
    read(encoder.push(motion(100, 50), i * 33 * kMs, 33 * kMs));
  read(encoder.finish());
  EXPECT_EQ(ids.size(), 2 * kHour);
  EXPECT_NEAR(static_cast<double>(felt), static_cast<double>(kHour), 10);
}

TEST(HmpgTrack, NothingMeasuredIsSilence) {
  HmpgEncoder encoder(100 * kMs, kDate);
  std::vector<CodedUnit> units;
  for (std::uint64_t i = 0; i < 90; ++i)
    append(units, encoder.push(motion(100, 0, i / 30 == 1 ? 0 : 1), i * kFrame, kFrame));
  append(units, encoder.finish());
  EXPECT_EQ(units.front().type, UnitType::initialization);
  EXPECT_EQ(units.back().type, UnitType::silent);
  std::uint64_t end = 0;
  for (const auto &unit : units) {
    EXPECT_EQ(unit.time, end) << "no hole, no overlap";
    end = unit.time + unit.duration;
  }
  int felt = 0;
  for (const auto &sample : decode(units, false)) {
    const bool silent = sample.time > 30 * kFrame && sample.time < 59 * kFrame;
    felt += sample.motion.confidence > 0;
    EXPECT_FALSE(silent && sample.motion.confidence > 0);
  }
  EXPECT_EQ(felt, 60);
}

TEST(HmpgTrack, ALatecomerBeginsAtTheNextUnit) {
  HmpgEncoder encoder(100 * kMs, kDate);
  std::vector<CodedUnit> units;
  for (std::uint64_t i = 0; i < 90; ++i)
    append(units, encoder.push(motion(100, 0), i * kFrame, kFrame));
  HmpgDecoder decoder;
  EXPECT_EQ(decoder.push(units[5].bytes, units[5].time).problem,
            "data of no band (at byte 16 of the unit)");
  decoder.push(units[0].bytes, units[0].time);
  EXPECT_GT(decoder.push(units[6].bytes, units[6].time).samples.size(), 2U);
}

TEST(HmpgTrack, TimesThatJumpBeginAnew) {
  HmpgEncoder encoder(100 * kMs, kDate);
  std::vector<CodedUnit> units;
  for (const std::uint64_t time :
       std::vector<std::uint64_t>{0, 1ULL << 62, 5, ~0ULL - 1, 7, 40 * kMs})
    append(units, encoder.push(motion(100, 0), time, ~0ULL));
  append(units, encoder.finish());
  EXPECT_LT(units.size(), 20U);
  for (const auto &unit : units)
    EXPECT_TRUE(haptic::read_unit_header(unit.bytes));
}

// The golden pair: one motion in both forms of the standard. WRITE_GOLDEN=FOLDER writes it anew.
class Golden : public testing::Test {
protected:
  Golden() {
    for (std::uint64_t i = 0; i < 12; ++i) {
      samples.push_back(
          {motion(50.0 * static_cast<double>(i), -25, i == 7 ? 0 : 1), i * kFrame, kFrame});
      append(units, encoder.push(samples.back().motion, samples.back().time, kFrame));
    }
    append(units, encoder.finish());
  }

  static std::string content_of(const std::string &name) {
    std::ifstream file(SOURCE_ROOT "/tests/data/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  static void expect_file(const std::string &name, const std::string &content) {
    EXPECT_EQ(content, content_of(name)) << name;
    if (const char *folder = std::getenv("WRITE_GOLDEN"))
      std::ofstream(folder + ("/" + name), std::ios::binary) << content;
  }

  HmpgEncoder encoder{100 * kMs, kDate};
  std::vector<TrackSample> samples;
  std::vector<CodedUnit> units;
};

TEST_F(Golden, TheBytesStayTheSame) {
  std::string bytes;
  for (const auto &unit : units)
    bytes.append(unit.bytes.begin(), unit.bytes.end());
  expect_file("golden.hmpg", bytes);
  expect_file("golden.hjif", haptic::write_hjif(samples, kDate));
}

// Tracks of earlier versions: the last keyframe of a unit is at the first tick of the next.
TEST_F(Golden, UnitsThatShareATickAreFeltAlike) {
  const std::string old = content_of("golden-shared-ticks.hmpg");
  const Bytes bytes(old.begin(), old.end());
  HmpgDecoder decoder;
  std::vector<TrackSample> got;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto rest = std::span(bytes).subspan(at);
    const auto unit = rest.first(haptic::kUnitHeaderSize + haptic::read_unit_header(rest)->length);
    const auto result = decoder.push(unit, haptic::kNoTime);
    got.insert(got.end(), result.samples.begin(), result.samples.end());
    at += unit.size();
  }
  const auto expected = decode(units, false);
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(haptic::force_of_motion(got[i].motion), haptic::force_of_motion(expected[i].motion));
    EXPECT_NEAR(static_cast<double>(got[i].time), static_cast<double>(expected[i].time), 0.13e6);
  }
}

TEST_F(Golden, BothFormsAreFeltAlike) {
  const auto felt = [](std::vector<TrackSample> track) {
    std::erase_if(track, [](const TrackSample &s) { return s.motion.confidence == 0; });
    return track;
  };
  const auto binary = felt(decode(units, false));
  const auto json = felt(haptic::read_hjif(haptic::write_hjif(samples, kDate)).samples);
  ASSERT_EQ(binary.size(), 11U);
  ASSERT_EQ(json.size(), 11U);
  for (std::size_t i = 0; i < binary.size(); ++i) {
    EXPECT_EQ(binary[i].time, json[i].time);
    EXPECT_NEAR(haptic::force_of_motion(binary[i].motion).x,
                haptic::force_of_motion(json[i].motion).x, 0.0041);
  }
}

// ---- RTP ----------------------------------------------------------------------------------------

Bytes bytes_of(const haptic::HmpgPayload &payload) {
  Bytes bytes = payload.head;
  bytes.insert(bytes.end(), payload.part.begin(), payload.part.end());
  return bytes;
}

std::vector<Bytes> packetize(const Bytes &unit, std::size_t largest) {
  std::vector<Bytes> payloads;
  std::ranges::transform(haptic::packetize_unit(unit, largest), std::back_inserter(payloads),
                         bytes_of);
  return payloads;
}

TEST(HmpgRtp, ASingleUnitGetsOneByteOfHeader) {
  const Bytes unit = haptic::write_silent_unit(800);
  const auto payloads = packetize(unit, 1400);
  ASSERT_EQ(payloads.size(), 1U);
  EXPECT_EQ(payloads[0][0], 0x40); // independent, silent, layer 0
  EXPECT_EQ(Bytes(payloads[0].begin() + 1, payloads[0].end()), unit);
}

TEST(HmpgRtp, FragmentsGoTogetherAgain) {
  const Bytes unit = haptic::write_initialization_unit(haptic::track_experience(kDate));
  const auto payloads = packetize(unit, 40);
  ASSERT_GT(payloads.size(), 3U);
  haptic::UnitAssembler assembler;
  std::uint16_t sequence = 65534;
  for (std::size_t i = 0; i < payloads.size(); ++i) {
    EXPECT_LE(payloads[i].size(), 40U);
    EXPECT_EQ(payloads[i][0], 0x70);
    const bool first = i == 0;
    const bool last = i + 1 == payloads.size();
    EXPECT_EQ(payloads[i][1], (first ? 0x80 : 0) | (last ? 0x40 : 0) | 1);
    const auto result = assembler.push(sequence++, payloads[i]);
    EXPECT_EQ(result.problem, nullptr);
    EXPECT_EQ(result.units, last ? std::vector<Bytes>{unit} : std::vector<Bytes>{});
  }
}

TEST(HmpgRtp, ALostFragmentLosesItsUnitOnly) {
  const Bytes unit = haptic::write_initialization_unit(haptic::track_experience(kDate));
  const auto payloads = packetize(unit, 40);
  haptic::UnitAssembler assembler;
  std::uint16_t sequence = 0;
  for (std::size_t i = 0; i < payloads.size(); ++i, ++sequence)
    if (i != 2) {
      EXPECT_TRUE(assembler.push(sequence, payloads[i]).units.empty());
    }
  for (const auto &payload : payloads) {
    const auto result = assembler.push(sequence++, payload);
    if (&payload == &payloads.back()) {
      EXPECT_EQ(result.units, std::vector<Bytes>{unit});
      EXPECT_TRUE(result.after_loss);
    }
  }
}

TEST(HmpgRtp, UnitsWaitForInitializationAndDependentOnesForAnIndependentOne) {
  haptic::UnitAssembler assembler;
  const auto send = [&](std::uint16_t sequence, const Bytes &unit) {
    return assembler.push(sequence, packetize(unit, 1400)[0]);
  };
  const Bytes independent = haptic::write_silent_unit(10);
  Bytes dependent = independent;
  dependent[0] |= 1;
  EXPECT_TRUE(send(0, independent).units.empty());
  EXPECT_FALSE(
      send(1, haptic::write_initialization_unit(haptic::track_experience(kDate))).units.empty());
  EXPECT_FALSE(send(2, independent).units.empty());
  EXPECT_FALSE(send(3, dependent).units.empty());
  EXPECT_TRUE(send(5, dependent).units.empty());
  EXPECT_FALSE(send(6, independent).units.empty());
  EXPECT_FALSE(send(7, dependent).units.empty());
}

// RFC 9993, section 5.3.3: one byte of payload header, then each unit behind its size in 16 bits.
TEST(HmpgRtp, UnitsOfOneTimeStampShareAPacket) {
  const Bytes first = haptic::write_initialization_unit(haptic::track_experience(kDate));
  const Bytes second = haptic::write_silent_unit(10);
  const std::array<std::span<const std::uint8_t>, 2> units = {first, second};
  const Bytes payload = bytes_of(haptic::aggregate_units(units, 1400).value());
  ASSERT_EQ(payload.size(), 1 + 2 + first.size() + 2 + second.size());
  EXPECT_EQ(payload[0], 0x50);
  EXPECT_EQ(payload[1] << 8 | payload[2], static_cast<int>(first.size()));
  EXPECT_FALSE(haptic::aggregate_units(units, payload.size() - 1));
  haptic::UnitAssembler assembler;
  const auto result = assembler.push(0, payload);
  EXPECT_EQ(result.problem, nullptr);
  EXPECT_EQ(result.units, (std::vector<Bytes>{first, second}));
}

TEST(HmpgRtp, OfADamagedAggregationPacketTheUnitsBeforeAreRead) {
  const Bytes first = haptic::write_initialization_unit(haptic::track_experience(kDate));
  const std::array<std::span<const std::uint8_t>, 2> units = {first, first};
  const Bytes payload = bytes_of(haptic::aggregate_units(units, 1400).value());
  for (std::size_t size = 1 + 2 + first.size(); size < payload.size(); ++size) {
    haptic::UnitAssembler assembler;
    const auto result = assembler.push(0, std::span(payload).first(size));
    EXPECT_EQ(result.units, std::vector<Bytes>{first});
    EXPECT_EQ(result.problem != nullptr, size > 1 + 2 + first.size());
  }
}

TEST(HmpgRtp, AggregationPacketsOfSeveralTimeStampsAreDropped) {
  haptic::UnitAssembler assembler;
  EXPECT_NE(assembler.push(0, Bytes{0x60, 0, 1, 0, 0, 0}).problem, nullptr);
}

} // namespace hmpg_test
