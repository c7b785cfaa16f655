// SPDX-License-Identifier: LGPL-2.1-or-later
// Times of a haptic track: nanoseconds in the program, ticks in MPEG haptics.
#pragma once

#include "core/track-sample.hpp"

#include <algorithm>
#include <cstdint>
#include <string>

namespace haptic {

inline constexpr std::uint64_t kSecond = 1'000'000'000; // ns

/// Ticks per second of what is written. RFC 9993, section 7, names this as the typical clock rate.
inline constexpr std::uint32_t kTrackTimescale = 8000;

/// Interval of a sample that names none: a frame of a usual video, ns.
inline constexpr std::uint64_t kUsualInterval = kSecond / 30;

/// A pause between two samples that is longer than this is silence; ticks of kTrackTimescale.
inline constexpr std::int64_t kLongestHold = kTrackTimescale / 4;

/// Sender's times that are further apart do not belong together: the sender was started anew.
inline constexpr std::uint64_t kLargestTimeStep = 10 * kSecond; // ns

/// Returns the ticks of a time in ns, to the nearest.
constexpr std::int64_t ticks_of(std::uint64_t ns, std::uint32_t timescale) noexcept {
  return static_cast<std::int64_t>(ns / kSecond * timescale +
                                   (ns % kSecond * timescale + kSecond / 2) / kSecond);
}

/// Returns the ns of ticks, to the nearest. Ticks are 0 or more.
constexpr std::uint64_t ns_of(std::int64_t ticks, std::uint32_t timescale) noexcept {
  const auto whole = static_cast<std::uint64_t>(ticks);
  return whole / timescale * kSecond + (whole % timescale * kSecond + timescale / 2) / timescale;
}

/// Returns for how many ticks of kTrackTimescale a sample of this duration (ns) holds at the end.
constexpr std::int64_t ticks_held(std::uint64_t duration) noexcept {
  return std::clamp<std::int64_t>(
      ticks_of(duration == kNoTime ? kUsualInterval : std::min(duration, kSecond), kTrackTimescale),
      1, kLongestHold);
}

/// Returns today's date in UTC, as in ISO 8601.
std::string today();

} // namespace haptic
