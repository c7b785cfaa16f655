// SPDX-License-Identifier: LGPL-2.1-or-later
// A motion track as MPEG haptics in JSON (.hjif; media type haptics/hjif of RFC 9695): ISO/IEC
// 23090-31:2025, clause 6.2.
#pragma once

#include "core/track-sample.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haptic {

/// Samples without a time are left out. `date` as in ISO 8601.
std::string write_hjif(std::span<const TrackSample> samples, const std::string &date);

struct HjifTrack {
  std::vector<TrackSample> samples;
  std::string unsupported; ///< what gives no force, or not the one of its curve
  std::string error;       ///< empty if all is well
  std::size_t offset = 0;  ///< bytes, of the error
};

/// Reads the perceptions of force: the bands of type Curve in channels that have a direction. The
/// rest is passed over and named.
HjifTrack read_hjif(std::string_view text);

} // namespace haptic
