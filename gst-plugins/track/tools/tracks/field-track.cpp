// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/field-track.hpp"

#include "samples/field-sampler.hpp"

#include <algorithm>

namespace haptic {
namespace {

// Fields at rest that were left out count as fields.
template <typename Cells, typename Call>
void for_each_decoded(std::span<const CodedField> track, const Call &call) {
  GridDecoder<Cells> decoder;
  for (const auto &coded : track) {
    const auto result = decoder.push(coded.bytes);
    if (decoder.rested() && coded.time >= decoder.field().interval)
      call(decoder.rest(), coded.time - decoder.field().interval, nullptr);
    if (result == GridDecoder<Cells>::Result::field)
      call(decoder.field(), coded.time, &coded);
  }
}

// Returns those in [from, to) coded anew: they depended on some that are cut off. Their times begin
// at 0.
std::vector<CodedField> fields_anew(std::span<const CodedField> track, std::uint64_t from,
                                    std::uint64_t to, std::uint8_t sequence) {
  std::vector<CodedField> fields;
  FieldEncoder encoder(kKeyInterval, sequence);
  std::vector<std::uint8_t> things;
  for_each_decoded<MotionCells>(
      track, [&](const MotionField &field, std::uint64_t time, const CodedField *coded) {
        if (time < from || time >= to)
          return;
        const bool has_others = coded && coded->things != things;
        if (coded)
          things = coded->things;
        if (auto bytes = encoder.push(field, has_others))
          fields.push_back({std::move(*bytes), time - from, kNoTime, FieldKind::motion, things});
      });
  return fields;
}

// The same of reliefs, which stay the same to the bit: none of them rests.
std::vector<CodedField> reliefs_anew(std::span<const CodedField> track, std::uint64_t from,
                                     std::uint64_t to, std::uint8_t sequence) {
  std::vector<CodedField> reliefs;
  ReliefDecoder decoder;
  ReliefEncoder encoder(kKeyInterval, sequence);
  for (const auto &coded : track)
    if (decoder.push(coded.bytes) == ReliefDecoder::Result::field && coded.time >= from &&
        coded.time < to)
      reliefs.push_back({encoder.push_held(decoder.state(), false), coded.time - from,
                         coded.duration, FieldKind::relief});
  return reliefs;
}

std::uint8_t sequence_of(std::span<const std::uint8_t> bytes) {
  return bytes[1]; // docs/formats/field-code.md
}

template <typename Cells>
void append_with_keys(std::span<const CodedField> track, FieldKind kind,
                      std::span<const std::uint64_t> times, std::vector<CodedField> &all) {
  GridDecoder<Cells> decoder;
  GridEncoder<Cells> encoder;
  for (const auto &coded : track) {
    if (coded.kind != kind || decoder.push(coded.bytes) != GridDecoder<Cells>::Result::field)
      continue;
    for (; !times.empty() && coded.time >= times.front(); times = times.subspan(1))
      encoder.restart();
    all.push_back({encoder.push_held(decoder.state(), decoder.rested()), coded.time, coded.duration,
                   kind, coded.things});
  }
}

} // namespace

void for_each_field(std::span<const CodedField> track,
                    const std::function<void(const MotionField &, std::uint64_t time)> &call) {
  MotionField whole; // with its things, which stay while the frame rests
  for_each_decoded<MotionCells>(
      track, [&](const MotionField &field, std::uint64_t time, const CodedField *coded) {
        auto things = std::move(whole.things);
        whole = field;
        whole.things = std::move(things);
        if (coded)
          unpack_field_things(coded->things, whole.things);
        call(whole, time);
      });
}

void for_each_relief(std::span<const CodedField> track,
                     const std::function<void(const ReliefField &, std::uint64_t time)> &call) {
  for_each_decoded<ReliefCells>(track, [&](const ReliefField &field, std::uint64_t time,
                                           const CodedField *) { call(field, time); });
}

std::vector<CodedField> cut_fields(std::span<const CodedField> track, std::uint64_t from,
                                   std::uint64_t to) {
  // Fields before the first pair of key fields depend on fields that are cut off: they are coded
  // anew.
  const auto key = std::ranges::find_if(track, [&](const CodedField &coded) {
    return coded.time >= from && begins_pair(coded.bytes);
  });
  const bool are_reliefs = !track.empty() && track.front().kind == FieldKind::relief;
  const auto coded_anew = [&](std::uint8_t sequence) {
    const std::span before(track.begin(), key);
    return are_reliefs ? reliefs_anew(before, from, to, sequence)
                       : fields_anew(before, from, to, sequence);
  };
  std::vector<CodedField> part = coded_anew(kFirstSequence);
  // Their sequence numbers lead to that of the key field, so that none seems lost.
  if (key != track.end() && !part.empty())
    part = coded_anew(static_cast<std::uint8_t>(sequence_of(key->bytes) - part.size()));
  for (const auto &coded : std::span(key, track.end()))
    if (coded.time >= from && coded.time < to)
      part.push_back({coded.bytes, coded.time - from, coded.duration, coded.kind, coded.things});
  return part;
}

std::vector<TrackSample> samples_at_hand(std::span<const CodedField> track,
                                         const std::vector<TimedPlace> &hand) {
  std::vector<TrackSample> samples;
  for_each_field(track, [&](const MotionField &field, std::uint64_t time) {
    const PointerPosition place = place_at(hand, static_cast<double>(time) * 1e-9);
    MotionSample sample = sample_field(field, place);
    sample.pointer_x = static_cast<float>(place.x);
    sample.pointer_y = static_cast<float>(place.y);
    samples.push_back({sample, time, field.interval});
  });
  return samples;
}

std::vector<CodedField> with_keys_at(std::span<const CodedField> track,
                                     std::span<const std::uint64_t> times) {
  std::vector<CodedField> all;
  append_with_keys<MotionCells>(track, FieldKind::motion, times, all);
  append_with_keys<ReliefCells>(track, FieldKind::relief, times, all);
  std::ranges::stable_sort(all, {}, &CodedField::time);
  return all;
}

double field_energy(const MotionField &field) {
  double sum = 0;
  for (const FieldCell &cell : field.cells)
    sum += static_cast<double>(cell.confidence) *
           (cell.velocity_x * cell.velocity_x + cell.velocity_y * cell.velocity_y);
  const double width = field.frame_width;
  return sum / (static_cast<double>(field.cells.size()) * width * width);
}

} // namespace haptic
