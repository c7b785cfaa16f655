// SPDX-License-Identifier: LGPL-2.1-or-later
// A motion track as MPEG haptics: samples to units and back (docs/formats/hmpg.md).
#pragma once

#include "core/track-sample.hpp"
#include "core/track-time.hpp"
#include "mpeg-haptics/force-curve.hpp"
#include "mpeg-haptics/hmpg.hpp"

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
  void begin(std::int64_t tick);
  void begin_bands();
  void close(std::int64_t end, const std::optional<CurveForce> &next);
  void silence(std::int64_t until);
  void emit(std::vector<std::uint8_t> bytes, UnitType type, std::int64_t begin, std::int64_t end);

  HmpgExperience experience_;
  std::int64_t unit_ticks_;
  bool started_ = false;
  std::vector<ForcePoint> points_; // of the unit that is being gathered
  std::int64_t cursor_ = 0;        // end of what has been written
  std::int64_t last_end_ = 0;      // of the sample before
  std::size_t effect_ = 0;         // id of the next effect in these bands
  std::vector<CodedUnit> done_;
};

/// Reads the units of a track. An effect may have its keyframes in several units, and the force
/// between two keyframes is known when the later one comes: samples are held back until then.
class HmpgDecoder {
public:
  struct Result {
    std::vector<TrackSample> samples; ///< `time` is that of the sample in the stream
    std::string problem;              ///< empty if all is well
    std::string unsupported;          ///< what gives no force, once; empty if there is nothing new
  };

  /// Of a live stream: samples are held back for kLongestHold at most.
  void set_live(bool live) noexcept { is_live_ = live; }
  /// Reads one unit. `time` (ns) is that of its beginning; with kNoTime the durations of the units
  /// before give it.
  Result push(std::span<const std::uint8_t> unit, std::uint64_t time);
  /// Returns what was held back: no unit continues those before.
  Result finish();
  /// Forgets the time of the stream and keeps the experience.
  void seek() noexcept {
    end_run();
    tick_.reset();
  }

private:
  Result begin_experience(HmpgExperience experience, std::uint64_t time);
  Result begin_unit(const UnitHeader &header, std::uint64_t time);
  const char *add_effects(const HmpgUnit &unit, std::int64_t begin);
  std::size_t add_effect(ChannelCurve curve, bool is_whole, const UnitHeader &header,
                         std::int64_t begin);
  std::string left_out(bool has_composite);
  std::optional<ChannelCurve> force_of(const HmpgCurve &effect, std::int64_t begin,
                                       std::size_t room) const;
  std::int64_t known_until();
  bool is_over(const ChannelCurve &curve, std::int64_t before) const;
  std::vector<ChannelCurve>::iterator next_of(const ChannelCurve &curve);
  void end_curves(std::int64_t before);
  void open_all();
  const char *sample_until(std::int64_t end, std::vector<TrackSample> &samples);
  void end_run() noexcept;

  std::optional<HmpgExperience> experience_;
  std::optional<std::int64_t> tick_; // end of the unit before
  bool is_live_ = false;
  bool has_composite_ = false;
  bool independent_go_on_ = false; // effects, in independent units
  std::string left_out_;           // what was reported

  std::vector<ChannelCurve> curves_; // effects that lasted at sampled_ or begin later, in order
  std::int64_t sampled_ = 0;         // ticks: samples before it were returned
  TickClock clock_;                  // of the unit before
  ForceSampler sampler_;
};

} // namespace haptic
