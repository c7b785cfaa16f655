// SPDX-License-Identifier: LGPL-2.1-or-later
// Where and when a thing of a film is to be taken.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>

namespace haptic {

struct HoldPoint {
  double x = 0; ///< 0..1
  double y = 0;
  double time = 0; ///< s, of the film
  bool operator==(const HoldPoint &) const = default;
};

/// Reads X,Y or X,Y@SECONDS. Returns nothing if the text is none.
inline std::optional<HoldPoint> read_hold_point(std::string_view text) {
  const char *const end = text.data() + text.size();
  const char *at = text.data();
  const auto number = [&](double &value, double most) {
    const auto read = std::from_chars(at, end, value);
    at = read.ptr;
    return read.ec == std::errc() && value >= 0 && value <= most;
  };
  const auto is = [&](char sign) { return at < end && *at++ == sign; };
  constexpr double kLatest = 1e9; // s
  HoldPoint point;
  if (!number(point.x, 1) || !is(',') || !number(point.y, 1) ||
      (at < end && (!is('@') || !number(point.time, kLatest))) || at != end)
    return std::nullopt;
  return point;
}

} // namespace haptic
