// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/transport-stream.hpp"

#include "made-film.hpp"

#include <gtest/gtest.h>
#include <map>

namespace transport_stream_test {

using haptic::FilmFormat;
using haptic::FilmSegment;
using haptic::ticks_of;
using haptic::TransportStreamWriter;
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kPacket = 188;
constexpr std::int64_t kFrame = 40'000'000; // ns
constexpr std::int64_t kNone = -1;
enum Pid : unsigned {
  kPrograms = 0,
  kMap = 0x1000,
  kVideo = 0x100,
  kSound = 0x101,
  kFields = 0x102
};

struct Packet {
  unsigned pid = 0;
  bool begins = false;
  unsigned counter = 0;
  bool is_random_access = false;
  std::int64_t clock = kNone; // ticks
  Bytes payload;
};

std::vector<Packet> packets_of(std::span<const std::uint8_t> stream) {
  std::vector<Packet> packets;
  EXPECT_EQ(stream.size() % kPacket, 0U);
  for (; stream.size() >= kPacket; stream = stream.subspan(kPacket)) {
    EXPECT_EQ(stream[0], 0x47);
    Packet packet;
    packet.pid = (stream[1] & 0x1FU) << 8 | stream[2];
    packet.begins = (stream[1] & 0x40) != 0;
    packet.counter = stream[3] & 0xFU;
    std::size_t at = 4;
    if ((stream[3] & 0x20) != 0) {
      at += 1 + stream[4];
      EXPECT_LE(at, kPacket);
      const unsigned flags = stream[4] > 0 ? stream[5] : 0;
      packet.is_random_access = (flags & 0x40) != 0;
      if ((flags & 0x10) != 0)
        packet.clock = std::int64_t{stream[6]} << 25 | stream[7] << 17 | stream[8] << 9 |
                       stream[9] << 1 | stream[10] >> 7;
    }
    packet.payload.assign(stream.begin() + static_cast<std::ptrdiff_t>(std::min(at, kPacket)),
                          stream.begin() + kPacket);
    packets.push_back(packet);
  }
  return packets;
}

// A unit of a stream: what stands behind a head with times.
struct Unit {
  std::int64_t presentation = kNone; // ticks
  std::int64_t decoding = kNone;
  std::int64_t clock = kNone;
  bool is_random_access = false;
  unsigned id = 0; // of the stream
  Bytes payload;
};

std::int64_t time_at(const Bytes &bytes, std::size_t at) {
  return std::int64_t{bytes[at] >> 1 & 7} << 30 | bytes[at + 1] << 22 | bytes[at + 2] >> 1 << 15 |
         bytes[at + 3] << 7 | bytes[at + 4] >> 1;
}

std::vector<Unit> units_of(const std::vector<Packet> &packets, unsigned pid) {
  std::vector<Unit> units;
  for (const Packet &packet : packets) {
    if (packet.pid != pid)
      continue;
    if (packet.begins)
      units.push_back(
          {.clock = packet.clock, .is_random_access = packet.is_random_access, .payload = {}});
    Bytes &payload = units.at(units.size() - 1).payload;
    payload.insert(payload.end(), packet.payload.begin(), packet.payload.end());
  }
  for (Unit &unit : units) {
    EXPECT_TRUE(unit.payload.size() >= 14 && unit.payload[0] == 0 && unit.payload[1] == 0 &&
                unit.payload[2] == 1);
    const std::size_t size = unit.payload[4] * 256U + unit.payload[5];
    EXPECT_TRUE(size == 0 || size + 6 == unit.payload.size());
    unit.id = unit.payload[3];
    unit.presentation = time_at(unit.payload, 9);
    unit.decoding = (unit.payload[7] & 0x40) != 0 ? time_at(unit.payload, 14) : unit.presentation;
    unit.payload.erase(unit.payload.begin(), unit.payload.begin() + 9 + unit.payload[8]);
  }
  return units;
}

// Frames in groups of which each third one is decoded two before its turn.
FilmSegment segment_of(std::size_t number, bool has_sound) {
  const std::int64_t start = static_cast<std::int64_t>(number) * 10 * kFrame;
  std::vector<test::FrameTime> times;
  for (const int i : {0, 3, 1, 2, 6, 4, 5, 9, 7, 8})
    times.push_back({start + i * kFrame, i == 0});
  FilmSegment segment = test::film_segment(times);
  for (std::size_t i = 0; i < segment.frames.size(); ++i) {
    segment.frames[i].bytes = test::film_frame(i == 0, 150 * i);
    segment.fields.push_back({segment.frames[i].turn, haptic::FieldKind::motion,
                              Bytes(100 * (i + 1), static_cast<std::uint8_t>(i + 1))});
    if (has_sound)
      segment.sounds.push_back({start + static_cast<std::int64_t>(i) * kFrame,
                                Bytes(1000, static_cast<std::uint8_t>(i))});
  }
  return segment;
}

// ffmpeg drops the times of private streams (id BD), not those of metadata (docs/formats/klv.md).
TEST(TransportStream, TheFieldsAreAStreamOfMetadata) {
  const FilmFormat format = test::film_format(false);
  const auto stream = TransportStreamWriter(format, 2 * kFrame).write(segment_of(0, false));
  for (const Unit &unit : units_of(packets_of(stream), kFields))
    EXPECT_EQ(unit.id, 0xFCU);
}

TEST(TransportStream, PacketsAreWholeAndCountedOnFromSegmentToSegment) {
  const FilmFormat format = test::film_format(true);
  TransportStreamWriter writer(format, 2 * kFrame);
  std::map<unsigned, unsigned> counters;
  std::size_t track = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (const Packet &packet : packets_of(writer.write(segment_of(i, true)))) {
      EXPECT_EQ(packet.counter, counters[packet.pid]++ % 16) << packet.pid;
      track += packet.pid == kFields ? kPacket : 0;
    }
  EXPECT_EQ(counters.size(), 5U);
  EXPECT_EQ(writer.track_bytes(), track);
}

TEST(TransportStream, EachSegmentBeginsWithTheTables) {
  for (const bool has_sound : {false, true}) {
    const FilmFormat format = test::film_format(has_sound);
    TransportStreamWriter writer(format, 0);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto packets = packets_of(writer.write(segment_of(i, has_sound)));
      ASSERT_GE(packets.size(), 3U);
      EXPECT_EQ(packets[0].pid, kPrograms);
      EXPECT_EQ(packets[1].pid, kMap);
      const Bytes &map = packets[1].payload;
      const std::size_t end = 4 + ((map[2] & 0xFU) << 8 | map[3]) - 4; // before the check
      std::map<unsigned, unsigned> types;                              // of the streams
      for (std::size_t at = 13; at + 5 <= end; at += 5 + map[at + 4])
        types[(map[at + 1] & 0x1FU) << 8 | map[at + 2]] = map[at];
      std::map<unsigned, unsigned> wanted = {{kVideo, 0x1B}, {kFields, 0x06}};
      if (has_sound)
        wanted[kSound] = 0x0F;
      EXPECT_EQ(types, wanted);
      EXPECT_FALSE(std::ranges::search(map, std::string("KLVA")).empty());
    }
  }
}

TEST(TransportStream, EachFrameHasItsTimesAndTheClockRunsAhead) {
  const FilmFormat format = test::film_format(false);
  TransportStreamWriter writer(format, 2 * kFrame);
  std::int64_t clock = kNone;
  std::optional<std::int64_t> origin;
  for (std::size_t i = 0; i < 2; ++i) {
    const FilmSegment segment = segment_of(i, false);
    const auto units = units_of(packets_of(writer.write(segment)), kVideo);
    ASSERT_EQ(units.size(), segment.frames.size());
    std::int64_t decoded = kNone;
    for (std::size_t k = 0; k < units.size(); ++k) {
      if (!origin)
        origin = units[k].presentation;
      EXPECT_EQ(units[k].presentation - *origin, segment.frames[k].presentation);
      EXPECT_LE(units[k].decoding, units[k].presentation) << "no frame is decoded too late";
      EXPECT_GT(units[k].decoding, decoded);
      EXPECT_GE(units[k].clock, 0) << "in each frame";
      EXPECT_GT(units[k].clock, clock);
      EXPECT_LT(units[k].clock, units[k].decoding);
      EXPECT_EQ(units[k].is_random_access, segment.frames[k].is_idr);
      EXPECT_EQ(units[k].payload, byte_stream_of(format, segment.frames[k]));
      decoded = units[k].decoding;
      clock = units[k].clock;
    }
  }
}

TEST(TransportStream, FieldsComeBackToTheByteBesideTheirFrames) {
  const FilmFormat format = test::film_format(true);
  TransportStreamWriter writer(format, 2 * kFrame);
  const FilmSegment segment = segment_of(0, true);
  const auto packets = packets_of(writer.write(segment));
  const std::int64_t origin = units_of(packets, kVideo)[0].presentation;
  auto units = units_of(packets, kFields);
  ASSERT_EQ(units.size(), segment.fields.size() + 1);
  EXPECT_TRUE(units.back().payload.empty()) << "it lets a player pass on the one before it";
  units.pop_back();
  for (std::size_t i = 0; i < units.size(); ++i) {
    EXPECT_EQ(units[i].presentation - origin, segment.fields[i].presentation);
    EXPECT_EQ(units[i].payload, segment.fields[i].set);
  }
}

TEST(TransportStream, SoundIsFramed) {
  const FilmFormat format = test::film_format(true);
  const FilmSegment segment = segment_of(0, true);
  const auto packets = packets_of(TransportStreamWriter(format, 0).write(segment));
  Bytes all;
  for (const Unit &unit : units_of(packets, kSound))
    all.insert(all.end(), unit.payload.begin(), unit.payload.end());
  std::size_t at = 0;
  for (const auto &sound : segment.sounds) {
    ASSERT_LE(at + 7 + sound.bytes.size(), all.size());
    EXPECT_EQ(all[at], 0xFF);
    EXPECT_EQ(all[at + 1], 0xF1);
    EXPECT_EQ((all[at + 3] & 3U) << 11 | all[at + 4] << 3 | all[at + 5] >> 5,
              7 + sound.bytes.size());
    EXPECT_TRUE(
        std::ranges::equal(std::span(all).subspan(at + 7, sound.bytes.size()), sound.bytes));
    at += 7 + sound.bytes.size();
  }
  EXPECT_EQ(at, all.size());
}

TEST(TransportStream, AKeyFrameBringsTheParameterSets) {
  const FilmFormat format = test::film_format(false);
  const Bytes key = byte_stream_of(format, {.is_idr = true, .bytes = test::film_frame(true)});
  const Bytes other = byte_stream_of(format, {.is_idr = false, .bytes = test::film_frame(false)});
  for (const auto &set : {format.sequence_sets[0], format.picture_sets[0]}) {
    EXPECT_FALSE(std::ranges::search(key, set).empty());
    EXPECT_TRUE(std::ranges::search(other, set).empty());
  }
  const Bytes start = {0, 0, 0, 1};
  for (const Bytes &coded : {key, other})
    EXPECT_TRUE(std::ranges::equal(std::span(coded).first(4), start));
}

} // namespace transport_stream_test
