// SPDX-License-Identifier: LGPL-2.1-or-later
// What can be said of a track of motion fields, and its parts.
#pragma once

#include "field-codec.hpp"
#include "track-sample.hpp"

#include <functional>
#include <span>
#include <vector>

namespace haptic {

/// Calls for every field that can be decoded, with its time.
void for_each_field(std::span<const CodedField> track,
                    const std::function<void(const MotionField &, std::uint64_t time)> &call);

/// The fields of these times (ns), which begin anew at 0, with a key field.
std::vector<CodedField> cut_fields(std::span<const CodedField> track, std::uint64_t from,
                                   std::uint64_t to);

/// How much moves in a frame: the mean over its cells of the square of the speed, by confidence,
/// in (frame widths a second)^2.
double field_energy(const MotionField &field);

} // namespace haptic
