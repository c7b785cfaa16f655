// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-track.hpp"

#include "field-sampler.hpp"

#include <algorithm>

namespace haptic {
namespace {

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
    all.push_back(
        {encoder.push_held(decoder.state(), decoder.rested()), coded.time, coded.duration, kind});
  }
}

} // namespace

void for_each_field(std::span<const CodedField> track,
                    const std::function<void(const MotionField &, std::uint64_t time)> &call) {
  FieldDecoder decoder;
  for (const auto &coded : track) {
    const auto result = decoder.push(coded.bytes);
    if (decoder.rested() && coded.time >= decoder.field().interval)
      call(decoder.rest(), coded.time - decoder.field().interval);
    if (result == FieldDecoder::Result::field)
      call(decoder.field(), coded.time);
  }
}

std::vector<CodedField> cut_fields(std::span<const CodedField> track, std::uint64_t from,
                                   std::uint64_t to) {
  // Fields before the first pair of key fields depend on fields that are cut off: they are coded
  // anew.
  const auto is_within = [&](std::uint64_t time) { return time >= from && time < to; };
  const auto key = std::ranges::find_if(track, [&](const CodedField &coded) {
    return coded.time >= from && begins_pair(coded.bytes);
  });
  const auto coded_anew = [&](std::uint8_t sequence) {
    std::vector<CodedField> fields;
    FieldEncoder encoder(kKeyInterval, sequence);
    for_each_field({track.begin(), key}, [&](const MotionField &field, std::uint64_t time) {
      if (!is_within(time))
        return;
      if (auto bytes = encoder.push(field))
        fields.push_back({std::move(*bytes), time - from});
    });
    return fields;
  };
  std::vector<CodedField> part = coded_anew(kFirstSequence);
  // Their sequence numbers lead to that of the key field, so that none seems lost.
  if (key != track.end() && !part.empty())
    part = coded_anew(static_cast<std::uint8_t>(sequence_of(key->bytes) - part.size()));
  for (const auto &coded : std::span(key, track.end()))
    if (is_within(coded.time))
      part.push_back({coded.bytes, coded.time - from, coded.duration});
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
