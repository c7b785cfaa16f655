// SPDX-License-Identifier: LGPL-2.1-or-later
// What hands at some places of the frame feel from a file: a log or a track of any form.
#pragma once

#include "felt/force-log.hpp"
#include "felt/touch-signal.hpp"
#include "samples/pointer-position.hpp"
#include "tracks/track-file.hpp"

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace haptic {

/// The hands: several at rest, or one along a path.
struct Hands {
  std::vector<PointerPosition> resting;
  std::vector<TimedPlace> path; ///< in rising order of time; if not empty, nobody rests

  std::size_t count() const noexcept { return path.empty() ? resting.size() : 1; }
};

/// s, [from, to)
struct TimeRange {
  double from = -std::numeric_limits<double>::infinity();
  double to = std::numeric_limits<double>::infinity();
};

class FeltFile {
public:
  /// Throws TrackFileError.
  explicit FeltFile(const std::string &path, const std::string &stream = {});

  const std::string &path() const noexcept { return path_; }
  /// Sets s that are added to all times; before hand() and feel().
  void delay(double offset) noexcept { offset_ = offset; }
  bool is_log() const noexcept { return !log_.forces.empty(); }
  /// s, when the video beside the track begins; nothing without a video, or if the track has lost
  /// the time stamps that tie it to the video.
  std::optional<double> film_begin() const;
  /// s, the first time of a track.
  double track_begin() const;
  bool has_motion() const noexcept { return !track_.empty(); }
  bool has_reliefs() const noexcept { return !track_.reliefs.empty(); }
  /// Whether it holds something for each place of the frame: fields or reliefs.
  bool has_places() const noexcept { return !track_.coded().empty(); }
  /// Returns where the hand was for which the file was made; nothing if it has places.
  std::vector<TimedPlace> hand() const;

  /// Once: makes the force that each of the hands feels within a time. What has no places has one
  /// hand, whatever `hands` says. Throws TrackFileError if there is none, or if it is too long.
  void feel(const Hands &hands, const ForceLaw &law, const TimeRange &range);
  /// Of the hands of feel(). Not of reliefs under hands at rest.
  ForceSignal signal(std::size_t hand) const;
  /// Of reliefs: what is under a hand of feel() that rests.
  std::span<const FeltSurface> surface(std::size_t hand) const { return surfaces_[hand]; }
  double begin() const noexcept { return begin_; } ///< s
  double end() const noexcept { return end_; }     ///< s

private:
  void feel_fields(const Hands &hands);
  void feel_reliefs(const Hands &hands);

  std::string path_;
  ForceLog log_; // or the forces of reliefs on a hand that moves
  TrackFile track_;
  ForceLaw law_;
  std::vector<std::vector<FeltMotion>> motions_;   // of each hand; empty of a log
  std::vector<std::vector<FeltSurface>> surfaces_; // of each hand at rest; of reliefs
  double offset_ = 0;                              // s
  double begin_ = 0;                               // s
  double end_ = -1;                                // s; before the begin: nothing is felt
};

} // namespace haptic
