// SPDX-License-Identifier: LGPL-2.1-or-later
// Tracks of motion fields or reliefs: decoding, cutting, and the amount of motion.
#pragma once

#include "core/track-sample.hpp"
#include "field-code/field-codec.hpp"
#include "tracks/hand-path.hpp"

#include <functional>
#include <span>
#include <vector>

namespace haptic {

/// Calls `call` for every field that can be decoded, with its time in ns.
void for_each_field(std::span<const CodedField> track,
                    const std::function<void(const MotionField &, std::uint64_t time)> &call);

/// The same for reliefs.
void for_each_relief(std::span<const CodedField> track,
                     const std::function<void(const ReliefField &, std::uint64_t time)> &call);

/// Returns the fields, or the reliefs, in [from, to) ns, decoded cell for cell the same. Their
/// times begin at 0, and the first one is a key field.
std::vector<CodedField> cut_fields(std::span<const CodedField> track, std::uint64_t from,
                                   std::uint64_t to);

/// Returns the motion under a hand in each field.
std::vector<TrackSample> samples_at_hand(std::span<const CodedField> track,
                                         const std::vector<TimedPlace> &hand);

/// Returns the same fields and reliefs, decoded cell for cell the same, with a key field at the
/// first one of each kind at or after each of the times (ns, in order). Those that cannot be
/// decoded are left out. In the order of their times, fields before reliefs.
std::vector<CodedField> with_keys_at(std::span<const CodedField> track,
                                     std::span<const std::uint64_t> times);

/// Returns the amount of motion in a frame: the mean over its cells of confidence times speed
/// squared, in (frame widths a second)^2.
double field_energy(const MotionField &field);

} // namespace haptic
