// SPDX-License-Identifier: LGPL-2.1-or-later
// A motion track as MPEG haptics in JSON (.hjif; media type haptics/hjif of RFC 9695).
#pragma once

#include "track-sample.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haptic {

/// The samples need times. `date` as in ISO 8601.
std::string write_hjif(std::span<const TrackSample> samples, const std::string &date);

struct HjifTrack {
  std::vector<TrackSample> samples;
  std::string error;      ///< empty if all is well
  std::size_t offset = 0; ///< bytes, of the error
};

/// What has a perception of force, with channels that say their direction and have bands of type
/// Curve; other bands are passed over.
HjifTrack read_hjif(std::string_view text);

} // namespace haptic
