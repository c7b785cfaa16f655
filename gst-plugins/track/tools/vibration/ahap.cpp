// SPDX-License-Identifier: LGPL-2.1-or-later
#include "vibration/ahap.hpp"

#include "json.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace haptic {

namespace {

constexpr double kUnits = 1e4; // a second, and of an intensity of 1

double intensity_of(const Intensity &one) {
  return std::sqrt(one.amplitude);
}

// The fewest points between whose lines no amplitude is off by more than the tolerance, found
// greedily.
std::vector<Intensity> simplify(std::span<const Intensity> all) {
  constexpr double kTolerance = 0.02;
  std::vector<Intensity> kept = {all.front()};
  std::size_t from = 0;
  const auto fits = [&](std::size_t to) {
    const double begin = intensity_of(all[from]);
    const double slope = (intensity_of(all[to]) - begin) / (all[to].time - all[from].time);
    for (std::size_t i = from + 1; i < to; ++i) {
      const double drawn = begin + slope * (all[i].time - all[from].time);
      if (std::abs(drawn * drawn - all[i].amplitude) > kTolerance)
        return false;
    }
    return true;
  };
  while (from + 1 < all.size()) {
    std::size_t to = from + 1;
    while (to + 1 < all.size() && fits(to + 1))
      ++to;
    kept.push_back(all[to]);
    from = to;
  }
  return kept;
}

Json parameter(const char *name, double value) {
  return {{"ParameterID", name}, {"ParameterValue", rounded(value, kUnits)}};
}

Json event(const char *type, double time, double duration, double intensity) {
  constexpr double kSharpness = 0.5;
  Json event = {{"EventType", type}, {"Time", rounded(time, kUnits)}};
  if (duration > 0)
    event["EventDuration"] = rounded(duration, kUnits);
  event["EventParameters"] = {parameter("HapticIntensity", intensity),
                              parameter("HapticSharpness", kSharpness)};
  return {{"Event", event}};
}

Json curve(std::span<const Intensity> points) {
  const double begin = points.front().time;
  Json all = Json::array();
  for (const Intensity &point : points)
    all.push_back({{"Time", rounded(point.time - begin, kUnits)},
                   {"ParameterValue", rounded(intensity_of(point), kUnits)}});
  return {{"ParameterCurve",
           {{"ParameterID", "HapticIntensityControl"},
            {"Time", rounded(begin, kUnits)},
            {"ParameterCurveControlPoints", all}}}};
}

// What is felt from `felt.front()` to `felt.back()`.
void write_stretch(Json &pattern, std::span<const Intensity> felt) {
  constexpr double kShortest = 0.05;  // s
  constexpr std::size_t kPoints = 16; // of a curve
  const double begin = felt.front().time;
  const double duration = felt.back().time - begin;
  if (duration < kShortest) {
    pattern.push_back(
        event("HapticTransient", begin, 0,
              intensity_of(*std::ranges::max_element(felt, {}, &Intensity::amplitude))));
    return;
  }
  pattern.push_back(event("HapticContinuous", begin, duration, 1));
  const std::vector<Intensity> points = simplify(felt);
  // The last point of a curve is the first of the next.
  for (std::size_t at = 0; at + 1 < points.size(); at += kPoints - 1)
    pattern.push_back(curve(std::span(points).subspan(at, std::min(kPoints, points.size() - at))));
}

} // namespace

double amplitude_of(std::span<const float> samples, int channels) {
  double squares = 0;
  for (const double sample : samples)
    squares += sample * sample;
  return std::min(1.0, std::sqrt(2 * squares * channels / static_cast<double>(samples.size())));
}

std::string write_ahap(std::span<const Intensity> all) {
  constexpr double kLongest = 30; // s, of an event
  constexpr double kSilent = 0.005;
  Json pattern = Json::array();
  for (std::size_t from = 0; from < all.size();) {
    if (all[from].amplitude < kSilent) {
      ++from;
      continue;
    }
    std::size_t to = from + 1;
    while (to < all.size() && all[to - 1].amplitude >= kSilent &&
           all[to].time - all[from].time <= kLongest)
      ++to;
    write_stretch(pattern, all.subspan(from, to - from));
    // A longer one goes on in the next event without a gap.
    const bool goes_on = to < all.size() && all[to - 1].amplitude >= kSilent;
    from = goes_on ? to - 1 : to;
  }
  return Json{{"Version", 1.0}, {"Pattern", std::move(pattern)}}.dump() + '\n';
}

} // namespace haptic
