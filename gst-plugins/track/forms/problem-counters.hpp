// SPDX-License-Identifier: LGPL-2.1-or-later
// Counts what is wrong with the stream of a haptic track. Each kind is a warning once, then only
// counted.
#pragma once

#include "forms/track-form.hpp"
#include "messages.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <gst/gst.h>

namespace haptic {

/// For any thread.
class ProblemCounters {
public:
  void count(TrackProblemKind kind) { ++counts_[row_of(kind).counter]; }

  /// Returns the warning for the user, or null if its counter had one since reset().
  const char *first_warning(TrackProblemKind kind) {
    const Row &row = row_of(kind);
    return warned_[row.counter].exchange(true) ? nullptr : row.message;
  }

  void reset() {
    for (auto &warned : warned_)
      warned = false;
    for (auto &count : counts_)
      count = 0;
  }

  void write(GstStructure &stats) const {
    for (std::size_t i = 0; i < kCounters; ++i)
      gst_structure_set(&stats, kNames[i], G_TYPE_UINT64, counts_[i].load(), nullptr);
  }

private:
  enum Counter {
    kDamaged,
    kForeign,
    kOtherVersion,
    kOtherKind,
    kWithoutTime,
    kUntied,
    kMissing,
    kCounters
  };
  static constexpr std::array<const char *, kCounters> kNames = {
      "damaged", "foreign", "other-version", "other-kind", "without-time", "untied", "missing"};

  struct Row {
    TrackProblemKind kind;
    Counter counter;
    const char *message;
  };
  static constexpr Row kRows[] = {
      {TrackProblemKind::damaged, kDamaged, messages::kTrackIsDamaged},
      {TrackProblemKind::foreign_klv, kForeign, messages::kTrackHasForeignKlv},
      {TrackProblemKind::foreign_text, kForeign, messages::kTrackHasForeignText},
      {TrackProblemKind::other_version, kOtherVersion, messages::kTrackIsOfLaterVersion},
      {TrackProblemKind::other_kind, kOtherKind, messages::kTrackIsOfOtherKind},
      {TrackProblemKind::unsupported, kOtherKind, messages::kHmpgIsUnsupported},
      {TrackProblemKind::missing, kMissing, messages::kTrackLostFields},
      {TrackProblemKind::without_time, kWithoutTime, messages::kTrackHasNoTimes},
      {TrackProblemKind::untied, kUntied, messages::kTrackIsUntied},
  };

  static const Row &row_of(TrackProblemKind kind) {
    return *std::ranges::find(kRows, kind, &Row::kind);
  }

  std::array<std::atomic<guint64>, kCounters> counts_{};
  std::array<std::atomic<bool>, kCounters> warned_{};
};

} // namespace haptic
