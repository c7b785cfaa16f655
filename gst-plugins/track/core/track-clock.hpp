// SPDX-License-Identifier: LGPL-2.1-or-later
// Gives samples back the time stamps that their buffers lost: some remuxers drop them.
#pragma once

#include "core/track-time.hpp"

#include <cstdint>

namespace haptic {

/// The two times of the last sample: `pts` of its buffer and `time` of the sender, in ns.
class TrackClock {
public:
  /// Returns the time stamp of a sample with this time of the sender: that of the last sample,
  /// moved on by the difference of the sender's times. `start` if there was none.
  std::uint64_t recovered(std::uint64_t time, std::uint64_t start) const noexcept;

  /// Whether any sample had a time stamp: only then is the place of the others known.
  bool is_tied() const noexcept { return pts_ != kNoTime; }

  /// A sample with this time of the sender came before any that has a time stamp. Returns whether
  /// the track has had none for so long that it has lost them: streams that are cut begin with some
  /// samples without.
  bool wait_for_tie(std::uint64_t time) noexcept;

  /// Whether samples came, but none that has a time stamp.
  bool is_waiting() const noexcept { return !is_tied() && first_untied_ != kNoTime; }

  /// Does nothing without `pts`. `time` and `duration` may be kNoTime.
  void remember(std::uint64_t pts, std::uint64_t time, std::uint64_t duration) noexcept;

  /// Another stream follows.
  void forget() noexcept;

private:
  std::uint64_t pts_ = kNoTime;
  std::uint64_t time_ = kNoTime;
  std::uint64_t duration_ = 0;
  std::uint64_t first_untied_ = kNoTime; // the sender's
};

} // namespace haptic
