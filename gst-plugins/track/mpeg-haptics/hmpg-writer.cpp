// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/bits.hpp"
#include "mpeg-haptics/hmpg-packets.hpp"
#include "mpeg-haptics/hmpg.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

void append_packet(std::vector<std::uint8_t> &payload, PacketType type, const BitWriter &content) {
  BitWriter header;
  header.put(type, 6);
  header.put(content.bytes().size(), 17);
  header.put(0, 1);
  payload.insert(payload.end(), header.bytes().begin(), header.bytes().end());
  payload.insert(payload.end(), content.bytes().begin(), content.bytes().end());
}

std::vector<std::uint8_t> make_unit(UnitType type, std::uint32_t duration,
                                    const std::vector<std::uint8_t> &payload) {
  BitWriter header;
  header.put(static_cast<std::uint64_t>(type), 6);
  header.put(0, 2); // independent
  header.put(0, 4); // layer
  header.put(duration, 24);
  header.put(payload.size(), 32);
  header.put(0, 4);
  std::vector<std::uint8_t> unit = header.bytes();
  unit.insert(unit.end(), payload.begin(), payload.end());
  return unit;
}

// Time 32 bits, timescale 32, nominal duration 24, deviation 24, overlapping 1.
BitWriter timing_packet(const HmpgExperience &e) {
  BitWriter out;
  out.put(e.time, 32);
  out.put(e.timescale, 32);
  out.put(e.nominal, 24);
  out.put(e.deviation, 24);
  out.put(0, 1); // units do not overlap
  return out;
}

// Clause 5.2: version, profile, level 8 bits, date, description, perceptions 8, avatars 8.
BitWriter haptics_packet(const HmpgExperience &e) {
  BitWriter out;
  out.text(e.version);
  out.text(e.profile);
  out.put(e.level, 8);
  out.text(e.date);
  out.text(e.description);
  out.put(e.perceptions.size(), 8);
  out.put(0, 8); // avatars
  return out;
}

// Clause 5.4, in the order of the puts.
BitWriter perception_packet(const HmpgPerception &p, std::size_t channels) {
  BitWriter out;
  out.put(p.id, 8);
  out.put(0, 8); // priority
  out.text(p.description);
  out.put(p.modality, 8);
  out.put(0, 8);  // avatar
  out.put(0, 16); // library
  out.put(0, 1);  // no semantic scheme
  out.put(static_cast<std::uint8_t>(kUnitExponent), 8);
  out.put(static_cast<std::uint8_t>(p.exponent), 8);
  out.put(0, 8); // devices
  out.put(channels, 16);
  return out;
}

// Clause 5.6. A gain g in -10000..10000 is floor((g + 10000) / 20000 * (2^32 - 1)).
BitWriter channel_packet(const HmpgChannel &c, std::size_t bands) {
  BitWriter out;
  out.put(c.id, 16);
  out.put(c.perception, 8);
  out.put(0, 8); // priority
  out.text(c.description);
  out.put(kNoDevice, 8);
  const double gain = std::clamp(c.gain, -kWidestGain, kWidestGain);
  out.put(static_cast<std::uint64_t>((gain + kWidestGain) / (2 * kWidestGain) * kCodes32), 32);
  out.put(static_cast<std::uint64_t>(1 / kWidestGain * kCodes32), 32); // mixing coefficient 1
  out.put(c.direction ? kOptionDirection : 0, 8);
  out.put(0, 32); // sampling frequency: none
  if (c.direction)
    for (const auto part : *c.direction)
      out.put(static_cast<std::uint8_t>(part), 8);
  out.put(0, 16); // vertices
  out.put(bands, 8);
  return out;
}

// Clause 5.7.
BitWriter band_packet(const HmpgBand &b) {
  BitWriter out;
  out.put(b.id, 8);
  out.put(b.perception, 8);
  out.put(b.channel, 16);
  out.put(0, 8); // priority
  out.put(static_cast<std::uint64_t>(b.type), 3);
  if (b.type == BandType::curve)
    out.put(static_cast<unsigned>(b.curve), 4);
  out.put(0, 16);
  out.put(kForceBandwidth, 16);
  out.put(0, 16); // effects: the units bring them
  return out;
}

// Clauses 5.8 and 5.9. A position has 25 bits with a sign, from the beginning of the unit; that of
// a keyframe has 16, from the beginning of its effect.
BitWriter data_packet(const HmpgCurve &curve) {
  const std::int32_t begin = curve.keyframes.empty() ? 0 : curve.keyframes.front().position;
  BitWriter out;
  out.put(0, 1); // random access
  out.put(curve.perception, 8);
  out.put(curve.channel, 16);
  out.put(curve.band, 8);
  out.put(1, 16); // effects
  out.put(curve.effect, 16);
  out.put(kBasisEffect, 2);
  out.put(static_cast<std::uint32_t>(begin), 25);
  out.put(0, 1); // no semantics
  out.put(curve.keyframes.size(), 16);
  for (const auto &keyframe : curve.keyframes) {
    out.put(keyframe.amplitude, 8);
    out.put(static_cast<std::uint32_t>(keyframe.position - begin), 16);
  }
  return out;
}

} // namespace

std::vector<std::uint8_t> write_initialization_unit(const HmpgExperience &e) {
  std::vector<std::uint8_t> payload;
  append_packet(payload, kInitializationTiming, timing_packet(e));
  append_packet(payload, kMetadataHaptics, haptics_packet(e));
  for (const auto &perception : e.perceptions)
    append_packet(
        payload, kMetadataPerception,
        perception_packet(perception, static_cast<std::size_t>(std::count_if(
                                          e.channels.begin(), e.channels.end(), [&](const auto &c) {
                                            return c.perception == perception.id;
                                          }))));
  for (const auto &channel : e.channels)
    append_packet(payload, kMetadataChannel,
                  channel_packet(channel, static_cast<std::size_t>(std::count_if(
                                              e.bands.begin(), e.bands.end(), [&](const auto &b) {
                                                return b.channel == channel.id;
                                              }))));
  for (const auto &band : e.bands)
    append_packet(payload, kMetadataBand, band_packet(band));
  return make_unit(UnitType::initialization, 0, payload);
}

std::vector<std::uint8_t> write_temporal_unit(std::uint32_t duration,
                                              std::span<const HmpgCurve> curves) {
  std::vector<std::uint8_t> payload;
  for (const auto &curve : curves)
    append_packet(payload, kData, data_packet(curve));
  return make_unit(UnitType::temporal, duration, payload);
}

std::vector<std::uint8_t> write_silent_unit(std::uint32_t duration) {
  return make_unit(UnitType::silent, duration, {});
}

} // namespace haptic
