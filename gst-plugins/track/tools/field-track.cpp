// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-track.hpp"

#include <algorithm>

namespace haptic {

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
  // Fields before the first key field depend on fields that are cut off: they are coded anew.
  const auto is_within = [&](std::uint64_t time) { return time >= from && time < to; };
  const auto key = std::ranges::find_if(track, [&](const CodedField &coded) {
    return coded.time >= from && is_key_field(coded.bytes);
  });
  std::vector<CodedField> part;
  FieldEncoder encoder;
  for_each_field({track.begin(), key}, [&](const MotionField &field, std::uint64_t time) {
    if (!is_within(time))
      return;
    if (auto bytes = encoder.push(field))
      part.push_back({std::move(*bytes), time - from});
  });
  for (const auto &coded : std::span(key, track.end()))
    if (is_within(coded.time))
      part.push_back({coded.bytes, coded.time - from, coded.duration});
  return part;
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
