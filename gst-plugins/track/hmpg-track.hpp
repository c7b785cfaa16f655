// SPDX-License-Identifier: LGPL-2.1-or-later
// A motion track as MPEG haptics: samples to units and back (docs/formats/hmpg.md).
#pragma once

#include "force-curve.hpp"
#include "hmpg.hpp"
#include "track-sample.hpp"
#include "track-time.hpp"

#include <optional>
#include <string>

namespace haptic {

/// Returns the experience of a motion track: one perception of force with two channels.
HmpgExperience track_experience(std::string date);

struct CodedUnit {
  std::vector<std::uint8_t> bytes;
  std::uint64_t time = 0;     ///< ns
  std::uint64_t duration = 0; ///< ns
  UnitType type = UnitType::initialization;
};

/// Collects samples into units. Every temporal unit is independent: a reader may begin at any of
/// them.
class HmpgEncoder {
public:
  /// `unit_duration` in ns, 1 ms to 4 s; `date` as in ISO 8601.
  HmpgEncoder(std::uint64_t unit_duration, std::string date);

  /// Returns the units that are complete. Samples come in the order of their times (ns); one that
  /// goes back begins the track anew.
  std::vector<CodedUnit> push(const MotionSample &sample, std::uint64_t time,
                              std::uint64_t duration);
  /// Returns the rest of the track and a silent unit.
  std::vector<CodedUnit> finish();

private:
  struct Point {
    std::int64_t tick;
    CurveForce force;
  };
  void begin(std::int64_t tick);
  void close(std::int64_t end, const std::optional<CurveForce> &next);
  void silence(std::int64_t until);
  void emit(std::vector<std::uint8_t> bytes, UnitType type, std::int64_t begin, std::int64_t end);

  HmpgExperience experience_;
  std::int64_t unit_ticks_;
  bool started_ = false;
  std::vector<Point> points_; // of the unit that is being gathered
  std::int64_t cursor_ = 0;   // end of what has been written
  std::int64_t last_end_ = 0; // of the sample before
  std::uint16_t effect_ = 0;
  std::vector<CodedUnit> done_;
};

/// Reads the units of a track.
class HmpgDecoder {
public:
  struct Result {
    std::vector<TrackSample> samples; ///< `time` is that of the sample in the stream
    std::string problem;              ///< empty if all is well
  };

  /// Reads one unit. `time` (ns) is that of its beginning; with kNoTime the durations of the units
  /// before give it.
  Result push(std::span<const std::uint8_t> unit, std::uint64_t time);
  /// Forgets the time of the stream and keeps the experience.
  void seek() noexcept { tick_.reset(); }
  /// Forgets everything.
  void forget() noexcept {
    experience_.reset();
    tick_.reset();
    last_ = kNoTime;
  }

private:
  Result read_temporal(const HmpgUnit &unit, std::uint64_t begin);

  std::optional<HmpgExperience> experience_;
  std::optional<std::int64_t> tick_; // end of the unit before
  std::uint64_t last_ = kNoTime;     // ns, time of the sample before
};

} // namespace haptic
