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
  std::vector<FieldThing> things; // stay while the frame rests
  for_each_decoded<MotionCells>(
      track, [&](MotionField field, std::uint64_t time, const CodedField *coded) {
        if (coded)
          unpack_field_things(coded->things, things);
        field.things = things;
        call(field, time);
      });
}

void for_each_relief(std::span<const CodedField> track,
                     const std::function<void(const ReliefField &, std::uint64_t time)> &call) {
  for_each_decoded<ReliefCells>(track, [&](const ReliefField &field, std::uint64_t time,
                                           const CodedField *) { call(field, time); });
}

std::vector<CodedField> cut_fields(std::span<const CodedField> track, std::uint64_t from,
                                   std::uint64_t to) {
  // Pairs of key fields stay where they are, beside the key frames of a film.
  std::vector<std::uint64_t> keys = {from};
  for (const auto &coded : track)
    if (coded.time > from && begins_pair(coded.bytes))
      keys.push_back(coded.time);
  std::vector<CodedField> part = with_keys_at(track, keys);
  std::erase_if(part,
                [&](const CodedField &coded) { return coded.time < from || coded.time >= to; });
  for (CodedField &coded : part)
    coded.time -= from;
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
