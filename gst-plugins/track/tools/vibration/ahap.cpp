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
    json.Double(intensity_of(point));
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
                intensity_of(*std::ranges::max_element(felt, {}, &Intensity::amplitude)));
    return;
  }
  write_event(json, "HapticContinuous", begin, duration, 1);
  const std::vector<Intensity> points = simplify(felt);
  // The last point of a curve is the first of the next.
  for (std::size_t at = 0; at + 1 < points.size(); at += kPoints - 1)
    write_curve(json, std::span(points).subspan(at, std::min(kPoints, points.size() - at)));
}

} // namespace

IntensityMeter::IntensityMeter(int channels, int rate, double carrier)
    : samples_(static_cast<std::size_t>(std::lround(2 * rate / carrier)) *
               static_cast<std::size_t>(channels)),
      window_(static_cast<double>(samples_) / channels / rate), channels_(channels) {}

void IntensityMeter::push(std::span<const float> samples) {
  for (const float sample : samples) {
    squares_ += static_cast<double>(sample) * sample;
    if (++count_ < samples_)
      continue;
    const auto number = static_cast<double>(intensities_.size());
    const double mean = squares_ * channels_ / static_cast<double>(samples_);
    intensities_.push_back({(number + 0.5) * window_, std::min(1.0, std::sqrt(2 * mean))});
    count_ = 0;
    squares_ = 0;
  }
}

std::string write_ahap(std::span<const Intensity> all) {
  constexpr double kLongest = 30; // s, of an event
  constexpr double kSilent = 0.005;
  rapidjson::StringBuffer text;
  Json json(text);
  json.SetMaxDecimalPlaces(4);
  json.StartObject();
  json.Key("Version");
  json.Double(1);
  json.Key("Pattern");
  json.StartArray();
  for (std::size_t from = 0; from < all.size();) {
    if (all[from].amplitude < kSilent) {
      ++from;
      continue;
    }
    std::size_t to = from + 1;
    while (to < all.size() && all[to - 1].amplitude >= kSilent &&
           all[to].time - all[from].time <= kLongest)
      ++to;
    write_stretch(json, all.subspan(from, to - from));
    // A longer one goes on in the next event without a gap.
    const bool goes_on = to < all.size() && all[to - 1].amplitude >= kSilent;
    from = goes_on ? to - 1 : to;
  }
  json.EndArray();
  json.EndObject();
  return std::string(text.GetString(), text.GetSize()) + "\n";
}

} // namespace haptic
