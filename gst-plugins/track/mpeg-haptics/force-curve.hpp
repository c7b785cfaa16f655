// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion samples as the force that MPEG haptics holds, to the right and up, and back.
#pragma once

#include "core/track-sample.hpp"
#include "mpeg-haptics/curve-interpolation.hpp"
#include "samples/motion-force.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace haptic {

/// Returns a motion that gives this force: equation 5 inverted, v = tan(pi/2 F) / alpha. Forces of
/// 0.98 and more give one speed.
MotionSample motion_of_force(CurveForce force) noexcept;

/// Returns a sample in which nothing was measured.
TrackSample silent_sample(std::uint64_t time, std::uint64_t duration) noexcept;

// What a track of MPEG haptics may hold that gives no force here, or not the one of its curve.
inline constexpr char kOtherPerceptions[] = "perceptions other than force";
inline constexpr char kNoDirection[] = "channels without a direction in the frame";
inline constexpr char kOtherBands[] = "transient, vectorial and wavelet bands";
inline constexpr char kOtherCurves[] =
    "curves other than linear, cubic and Akima, which are drawn as straight lines";
inline constexpr char kComposite[] = "composite effects";

/// Difference of amplitudes -1..1 that their 8 bits in .hmpg may hide: those of three keyframes.
inline constexpr double kCodeStep = 3 / 255.0;

/// One effect of one channel: a force along its direction. It lasts from its first point to its
/// last, both included.
struct ChannelCurve {
  using Point = CurvePoint;             ///< its value is a fraction of the full force
  std::array<double, 2> direction = {}; ///< right, up; of length 1 or less
  std::vector<Point> points;            ///< in the order of time
  CurveDrawing drawing;                 ///< what of the effect is not in the points yet
  double code_step = kCodeStep;         ///< difference of values that the coding may hide
  std::uint32_t id = 0;                 ///< of the band and the effect
  std::int64_t begin = 0;               ///< tick at which the effect says that it begins
  bool is_closed = false;               ///< no more points come
};

/// Multiplies the values. They stay far from where numbers end.
void scale_values(ChannelCurve &curve, double factor) noexcept;

/// Returns whether `a` begins before `b`.
bool begins_before(const ChannelCurve &a, const ChannelCurve &b) noexcept;

/// Returns whether an effect that begins at this tick continues the curve without a pause: at its
/// last keyframe, or a tick behind it.
bool touches(const ChannelCurve &curve, std::int64_t tick) noexcept;

/// Appends an effect that touches the curve. Where both have a point at one tick, that of the
/// effect counts. A last point of the curve that only leads to the effect is removed.
void join(ChannelCurve &curve, std::span<const ChannelCurve::Point> effect);

struct ForcePoint {
  std::int64_t tick = 0;
  CurveForce force;
};

/// Ticks to ns.
struct TickClock {
  double timescale = 1;  ///< ticks/s
  std::int64_t tick = 0; ///< at this tick
  std::uint64_t ns = 0;  ///< it is this time

  std::uint64_t ns_at(std::int64_t at) const noexcept;
};

/// Makes samples of the sum of curves, part by part.
class ForceSampler {
public:
  /// Appends the samples in [begin, end): one at each point, where the sum has a step, and 50 ms or
  /// less apart, since a sink takes a longer pause for silence; and a silent one where no curve is.
  /// `curves` are in the order of their beginnings. Returns what is wrong, or nothing.
  const char *append(std::span<const ChannelCurve> curves, std::int64_t begin, std::int64_t end,
                     const TickClock &clock, std::vector<TrackSample> &samples);
  /// Another part of the track follows.
  void restart() noexcept { *this = {}; }

private:
  static bool sum(std::span<const ChannelCurve> curves, std::int64_t begin, std::int64_t end,
                  std::vector<ForcePoint> &points);
  void append_filled(const std::vector<ForcePoint> &points, const TickClock &clock,
                     std::size_t &room, std::vector<ForcePoint> &filled);
  bool ends_flat(std::span<const ForcePoint> points) const;
  void append_felt(const std::vector<ForcePoint> &points, std::int64_t end, const TickClock &clock,
                   std::vector<TrackSample> &samples);

  std::optional<ForcePoint> before_; // the last point, if no silence followed
  std::uint64_t last_ = kNoTime;     // ns, time of the last felt sample
};

/// Points of one stretch of curves; more are refused.
inline constexpr std::size_t kMostForcePoints = 65536;

} // namespace haptic
