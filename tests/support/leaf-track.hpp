// SPDX-License-Identifier: LGPL-2.1-or-later
// A track of leaves in the wind: LeafFields, coded.
#pragma once

#include "core/track-sample.hpp"
#include "field-code/field-codec.hpp"
#include "leaf-fields.hpp"

#include <vector>

namespace test {

/// `step`: ns from one field to the next, by the times of the track.
inline std::vector<haptic::CodedField>
leaf_track(std::size_t count, std::uint64_t step = LeafFields::kInterval, unsigned seed = 1) {
  LeafFields leaves(seed);
  haptic::FieldEncoder encoder;
  std::vector<haptic::CodedField> track;
  for (std::size_t i = 0; i < count; ++i)
    track.push_back({encoder.push(leaves.next()).value(), i * step});
  return track;
}

} // namespace test
