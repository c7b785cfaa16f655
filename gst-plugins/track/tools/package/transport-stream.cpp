// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/transport-stream.hpp"

#include "film/big-endian.hpp"

#include <algorithm>
#include <limits>

namespace haptic {
namespace {

constexpr std::size_t kPacketHead = 4;
constexpr std::uint8_t kSync = 0x47;
constexpr std::uint8_t kFill = 0xFF;
// Of the first frame: decoding times and the clock, which runs ahead of them, stay positive.
constexpr std::int64_t kOrigin = 900'000;
constexpr std::int64_t kClockAhead = 63'000;
constexpr std::int64_t kTimeMask = (std::int64_t{1} << 33) - 1;
// A unit of sound begins with the next frame once it has so many bytes.
constexpr std::size_t kSoundUnit = 2600;

// Sections with their checks, behind a 0, since they begin at once (2.4.4): the program association
// table, and the program maps without and with sound. They name the pids of the header. The streams
// are H.264, AAC, and private data with the registration "KLVA".
constexpr std::uint8_t kPrograms[] = {0x00, 0x00, 0xB0, 0x0D, 0x00, 0x01, 0xC1, 0x00, 0x00,
                                      0x00, 0x01, 0xF0, 0x00, 0x2A, 0xB1, 0x04, 0xB2};
constexpr std::uint8_t kSilent[] = {0x00, 0x02, 0xB0, 0x1D, 0x00, 0x01, 0xC1, 0x00, 0x00,
                                    0xE1, 0x00, 0xF0, 0x00, 0x1B, 0xE1, 0x00, 0xF0, 0x00,
                                    0x06, 0xE1, 0x02, 0xF0, 0x06, 0x05, 0x04, 'K',  'L',
                                    'V',  'A',  0x14, 0xB1, 0xAA, 0xC9};
constexpr std::uint8_t kSounding[] = {0x00, 0x02, 0xB0, 0x22, 0x00, 0x01, 0xC1, 0x00, 0x00, 0xE1,
                                      0x00, 0xF0, 0x00, 0x1B, 0xE1, 0x00, 0xF0, 0x00, 0x0F, 0xE1,
                                      0x01, 0xF0, 0x00, 0x06, 0xE1, 0x02, 0xF0, 0x06, 0x05, 0x04,
                                      'K',  'L',  'V',  'A',  0xBA, 0x82, 0x27, 0x4C};

// A time in the head of a unit, with the four bits that say which (2.4.3.7).
void put_time(std::vector<std::uint8_t> &bytes, unsigned kind, std::int64_t ticks) {
  const auto time = static_cast<std::uint64_t>(ticks & kTimeMask);
  put_number(bytes, kind << 4 | (time >> 30 & 7) << 1 | 1, 1);
  put_number(bytes, (time >> 15 & 0x7FFF) << 1 | 1, 2);
  put_number(bytes, (time & 0x7FFF) << 1 | 1, 2);
}

} // namespace

std::vector<std::uint8_t> byte_stream_of(const FilmFormat &format, const SegmentFrame &frame) {
  constexpr std::array<std::uint8_t, 4> kStart = {0, 0, 0, 1};
  std::vector<std::uint8_t> coded = {0, 0, 0, 1, 9, 0xF0}; // a delimiter
  const auto put = [&](std::span<const std::uint8_t> unit) {
    coded.insert(coded.end(), kStart.begin(), kStart.end());
    coded.insert(coded.end(), unit.begin(), unit.end());
  };
  if (frame.is_idr)
    for (const auto *sets : {&format.sequence_sets, &format.picture_sets})
      for (const auto &set : *sets)
        put(set);
  for (std::size_t at = 0; at < frame.bytes.size();)
    put(read_unit(frame.bytes, at, 4));
  return coded;
}

TransportStreamWriter::TransportStreamWriter(const FilmFormat &format, std::int64_t reordering)
    : format_(format), reordering_(ticks_of(reordering) + (reordering > 0 ? 1 : 0)) {}

std::vector<std::uint8_t> TransportStreamWriter::write(const FilmSegment &segment) {
  out_.clear();
  put_tables();
  auto sound = segment.sounds.begin();
  auto field = segment.fields.begin();
  const auto put_fields = [&](std::int64_t until) {
    for (; field != segment.fields.end() && field->presentation <= until; ++field)
      put_unit(fields_, field->presentation, field->presentation, field->set, {});
  };
  const auto put_sounds = [&](std::int64_t until) {
    while (sound != segment.sounds.end() && ticks_of(sound->time) <= until) {
      const std::int64_t time = ticks_of(sound->time);
      std::vector<std::uint8_t> unit;
      for (; sound != segment.sounds.end() && unit.size() < kSoundUnit; ++sound)
        put_framed(unit, sound->bytes);
      put_unit(sound_, time, time, std::move(unit), {});
    }
  };
  for (const SegmentFrame &frame : segment.frames) {
    put_fields(frame.turn);
    put_sounds(frame.turn);
    const std::int64_t decoding = frame.turn - reordering_;
    put_unit(video_, frame.presentation, decoding, byte_stream_of(format_, frame),
             {decoding - kClockAhead + kOrigin, frame.is_idr});
  }
  put_fields(std::numeric_limits<std::int64_t>::max());
  // An empty unit: hls.js 1.7 passes on a unit of KLV when the next one of the same segment begins.
  if (!segment.fields.empty())
    put_unit(fields_, field[-1].presentation, field[-1].presentation, {}, {});
  put_sounds(std::numeric_limits<std::int64_t>::max());
  return std::move(out_);
}

void TransportStreamWriter::put_tables() {
  const std::array<Bytes, 2> sections = {kPrograms,
                                         format_.sound.empty() ? Bytes(kSilent) : Bytes(kSounding)};
  for (std::size_t i = 0; i < sections.size(); ++i) {
    std::vector<std::uint8_t> section(sections[i].begin(), sections[i].end());
    section.resize(kPacket - kPacketHead, kFill);
    put_packets(tables_[i], section, {});
  }
}

void TransportStreamWriter::put_unit(Stream &stream, std::int64_t presentation,
                                     std::int64_t decoding, std::vector<std::uint8_t> payload,
                                     Clock clock) {
  const bool has_decoding = decoding != presentation;
  std::vector<std::uint8_t> unit;
  put_number(unit, 0x100 | stream.id, 4);
  const std::size_t times = has_decoding ? 10 : 5;
  const std::size_t size = 3 + times + payload.size();
  // A frame may be too long for the number.
  put_number(unit, size > 0xFFFF || stream.id == video_.id ? 0 : size, 2);
  put_number(unit, has_decoding ? 0x81C0 : 0x8180, 2);
  put_number(unit, times, 1);
  put_time(unit, has_decoding ? 3 : 2, presentation + kOrigin);
  if (has_decoding)
    put_time(unit, 1, decoding + kOrigin);
  unit.insert(unit.end(), payload.begin(), payload.end());
  put_packets(stream, unit, clock);
}

void TransportStreamWriter::put_packets(Stream &stream, Bytes unit, Clock clock) {
  for (bool first = true; first || !unit.empty(); first = false) {
    constexpr std::size_t kRoom = kPacket - kPacketHead;
    std::vector<std::uint8_t> adaptation; // length, flags, clock and what fills the packet
    if (first && clock.reference >= 0) {
      adaptation = {0, static_cast<std::uint8_t>(0x10 | (clock.is_idr ? 0x40 : 0))};
      put_number(adaptation, static_cast<std::uint64_t>(clock.reference & kTimeMask) << 15 | 0x7E00,
                 6);
    }
    if (adaptation.size() + unit.size() < kRoom) {
      const std::size_t size = kRoom - unit.size();
      adaptation.resize(std::max(adaptation.size(), std::min<std::size_t>(size, 2))); // no flag
      adaptation.resize(size, kFill);
    }
    if (!adaptation.empty())
      adaptation[0] = static_cast<std::uint8_t>(adaptation.size() - 1);
    const std::size_t taken = std::min(kRoom - adaptation.size(), unit.size());
    put_number(out_, kSync, 1);
    put_number(out_, (first ? 0x4000U : 0U) | stream.pid, 2);
    put_number(out_, (adaptation.empty() ? 0x10U : 0x30U) | (stream.packets++ & 0xFU), 1);
    out_.insert(out_.end(), adaptation.begin(), adaptation.end());
    out_.insert(out_.end(), unit.begin(), unit.begin() + static_cast<std::ptrdiff_t>(taken));
    unit = unit.subspan(taken);
  }
}

// Appends the sound behind a head of ADTS (ISO/IEC 13818-7, 6.2).
void TransportStreamWriter::put_framed(std::vector<std::uint8_t> &unit, Bytes sound) const {
  const auto &config = format_.sound;
  const unsigned object = config[0] >> 3;
  const unsigned rate = (config[0] & 7U) << 1 | config[1] >> 7;
  const unsigned channels = config[1] >> 3 & 0xFU;
  const std::size_t size = sound.size() + 7;
  // Objects above 4 are extensions of AAC-LC, which a decoder finds itself.
  const unsigned profile = object >= 1 && object <= 4 ? object - 1 : 1;
  put_number(unit, 0xFFF1, 2);
  put_number(unit,
             std::uint64_t{profile} << 38 | std::uint64_t{rate} << 34 |
                 std::uint64_t{channels} << 30 | std::uint64_t{size} << 13 | 0x7FFU << 2,
             5);
  unit.insert(unit.end(), sound.begin(), sound.end());
}

} // namespace haptic
