// SPDX-License-Identifier: LGPL-2.1-or-later
// A motion sample, or a coded motion field or relief, with its own time: files and networks lose
// the time stamps of buffers.
#pragma once

#include "samples/motion-sample.hpp"

#include <cstdint>
#include <limits>
#include <vector>

namespace haptic {

/// The same value as GST_CLOCK_TIME_NONE.
inline constexpr std::uint64_t kNoTime = std::numeric_limits<std::uint64_t>::max();

struct TrackSample {
  MotionSample motion;
  std::uint64_t time = kNoTime;     ///< ns, stream time at the sender
  std::uint64_t duration = kNoTime; ///< ns

  bool operator==(const TrackSample &) const = default;
};

/// What the cells of a field hold.
enum class FieldKind { motion, relief };

struct CodedField {
  std::vector<std::uint8_t> bytes;  ///< of FieldEncoder or ReliefEncoder
  std::uint64_t time = kNoTime;     ///< ns, stream time at the sender
  std::uint64_t duration = kNoTime; ///< ns; none: the interval that the bytes hold
  FieldKind kind = FieldKind::motion;
  std::vector<std::uint8_t> things = {}; ///< of a motion field: packed as pack_field_things() does

  bool operator==(const CodedField &) const = default;
};

} // namespace haptic
