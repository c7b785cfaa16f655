// SPDX-License-Identifier: LGPL-2.1-or-later
#include "vibration/ahap.hpp"

#include <algorithm>
#include <cmath>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>
#include <vector>

namespace haptic {

namespace {

using Json = rapidjson::PrettyWriter<rapidjson::StringBuffer>;

struct Intensity {
  double time = 0;  // s
  double value = 0; // 0..1
};

// The amplitude of the carrier over windows of two of its periods, in their middles.
std::vector<Intensity> intensities(const Vibration &vibration, double carrier) {
  const auto window = static_cast<std::size_t>(std::lround(2 * vibration.rate / carrier));
  const std::size_t step = window * static_cast<std::size_t>(vibration.channels);
  std::vector<Intensity> result;
  for (std::size_t at = 0; at + step <= vibration.samples.size(); at += step) {
    double squares = 0;
    for (const float sample : vibration.samples.subspan(at, step))
      squares += static_cast<double>(sample) * sample;
    const auto middle = static_cast<double>(at) + static_cast<double>(step) / 2; // samples
    result.push_back({middle / (vibration.channels * vibration.rate),
                      std::min(1.0, std::sqrt(2 * squares / static_cast<double>(window)))});
  }
  return result;
}

// The fewest points of which no value between is farther from the line than the tolerance, found
// greedily.
std::vector<Intensity> simplify(std::span<const Intensity> all) {
  constexpr double kTolerance = 0.02;
  std::vector<Intensity> kept = {all.front()};
  std::size_t from = 0;
  const auto fits = [&](std::size_t to) {
    const double slope = (all[to].value - all[from].value) / (all[to].time - all[from].time);
    for (std::size_t i = from + 1; i < to; ++i)
      if (std::abs(all[from].value + slope * (all[i].time - all[from].time) - all[i].value) >
          kTolerance)
        return false;
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

void write_parameter(Json &json, const char *name, double value) {
  json.StartObject();
  json.Key("ParameterID");
  json.String(name);
  json.Key("ParameterValue");
  json.Double(value);
  json.EndObject();
}

void write_event(Json &json, const char *type, double time, double duration, double intensity) {
  constexpr double kSharpness = 0.5;
  json.StartObject();
  json.Key("Event");
  json.StartObject();
  json.Key("EventType");
  json.String(type);
  json.Key("Time");
  json.Double(time);
  if (duration > 0) {
    json.Key("EventDuration");
    json.Double(duration);
  }
  json.Key("EventParameters");
  json.StartArray();
  write_parameter(json, "HapticIntensity", intensity);
  write_parameter(json, "HapticSharpness", kSharpness);
  json.EndArray();
  json.EndObject();
  json.EndObject();
}

void write_curve(Json &json, std::span<const Intensity> points) {
  const double begin = points.front().time;
  json.StartObject();
  json.Key("ParameterCurve");
  json.StartObject();
  json.Key("ParameterID");
  json.String("HapticIntensityControl");
  json.Key("Time");
  json.Double(begin);
  json.Key("ParameterCurveControlPoints");
  json.StartArray();
  for (const Intensity &point : points) {
    json.StartObject();
    json.Key("Time");
    json.Double(point.time - begin);
    json.Key("ParameterValue");
    json.Double(point.value);
    json.EndObject();
  }
  json.EndArray();
  json.EndObject();
  json.EndObject();
}

// What is felt from `felt.front()` to `felt.back()`.
void write_stretch(Json &json, std::span<const Intensity> felt) {
  constexpr double kShortest = 0.05;  // s
  constexpr std::size_t kPoints = 16; // of a curve
  const double begin = felt.front().time;
  const double duration = felt.back().time - begin;
  if (duration < kShortest) {
    write_event(json, "HapticTransient", begin, 0,
                std::ranges::max_element(felt, {}, &Intensity::value)->value);
    return;
  }
  write_event(json, "HapticContinuous", begin, duration, 1);
  const std::vector<Intensity> points = simplify(felt);
  // The last point of a curve is the first of the next.
  for (std::size_t at = 0; at + 1 < points.size(); at += kPoints - 1)
    write_curve(json, std::span(points).subspan(at, std::min(kPoints, points.size() - at)));
}

} // namespace

std::string write_ahap(const Vibration &vibration, double carrier) {
  constexpr double kLongest = 30; // s, of an event
  constexpr double kSilent = 0.005;
  const std::vector<Intensity> all = intensities(vibration, carrier);
  rapidjson::StringBuffer text;
  Json json(text);
  json.SetMaxDecimalPlaces(4);
  json.StartObject();
  json.Key("Version");
  json.Double(1);
  json.Key("Pattern");
  json.StartArray();
  for (std::size_t from = 0; from < all.size();) {
    if (all[from].value < kSilent) {
      ++from;
      continue;
    }
    std::size_t to = from + 1;
    while (to < all.size() && all[to - 1].value >= kSilent &&
           all[to].time - all[from].time <= kLongest)
      ++to;
    write_stretch(json, std::span(all).subspan(from, to - from));
    // A longer one goes on in the next event without a gap.
    const bool goes_on = to < all.size() && all[to - 1].value >= kSilent;
    from = goes_on ? to - 1 : to;
  }
  json.EndArray();
  json.EndObject();
  return std::string(text.GetString(), text.GetSize()) + "\n";
}

} // namespace haptic
