// SPDX-License-Identifier: LGPL-2.1-or-later
// AHAP as Apple's Core Haptics reads it: its keys and ranges, and the intensity that a player
// makes.
#include "vibration/ahap.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace ahap_test {

constexpr int kRate = 8000;
constexpr int kCarrier = 180;

// A carrier whose amplitude follows a function of the time, s.
std::vector<float> vibration(double seconds, const std::function<double(double)> &amplitude) {
  std::vector<float> samples;
  for (int i = 0; i < seconds * kRate; ++i) {
    const double time = static_cast<double>(i) / kRate;
    samples.push_back(
        static_cast<float>(amplitude(time) * std::sin(2 * std::numbers::pi * kCarrier * time)));
  }
  return samples;
}

// A file as a player holds it.
class Player {
public:
  explicit Player(const std::vector<float> &samples, int channels = 1) {
    constexpr std::size_t kWindow = 2 * kRate / kCarrier; // frames
    const std::size_t size = kWindow * static_cast<std::size_t>(channels);
    std::vector<haptic::Intensity> all;
    for (std::size_t at = 0; at + size <= samples.size(); at += size)
      all.push_back({(static_cast<double>(all.size()) + 0.5) * kWindow / kRate,
                     haptic::amplitude_of(std::span(samples).subspan(at, size), channels)});
    const auto document = nlohmann::json::parse(haptic::write_ahap(all));
    EXPECT_EQ(document.at("Version"), 1.0);
    for (const auto &item : document.at("Pattern")) {
      EXPECT_EQ(item.size(), 1U);
      if (item.contains("Event"))
        add_event(item.at("Event"));
      else
        add_curve(item.at("ParameterCurve"));
    }
  }

  int continuous = 0;
  int transient = 0;
  double strongest = 0; // intensity of the transient events

  // The amplitude of an intensity is its square. Without the transient events.
  double at(double time) const {
    double event = 0;
    for (const auto &[begin, end] : events_)
      if (time >= begin && time <= end)
        event = 1;
    double control = 1;
    for (std::size_t i = 1; i < points_.size(); ++i)
      if (points_[i - 1].first <= time && time <= points_[i].first) {
        const auto &[t0, v0] = points_[i - 1];
        const auto &[t1, v1] = points_[i];
        control = t1 > t0 ? v0 + (v1 - v0) * (time - t0) / (t1 - t0) : v1;
      }
    return event * control * control;
  }

private:
  void add_event(const nlohmann::json &event) {
    const std::string type = event.at("EventType");
    const double time = event.at("Time");
    EXPECT_GE(time, 0);
    for (const auto &parameter : event.at("EventParameters")) {
      EXPECT_GE(parameter.at("ParameterValue"), 0);
      EXPECT_LE(parameter.at("ParameterValue"), 1);
    }
    if (type == "HapticTransient") {
      ++transient;
      for (const auto &parameter : event.at("EventParameters"))
        if (parameter.at("ParameterID") == "HapticIntensity")
          strongest = std::max(strongest, parameter.at("ParameterValue").get<double>());
      EXPECT_FALSE(event.contains("EventDuration"));
      return;
    }
    EXPECT_EQ(type, "HapticContinuous");
    ++continuous;
    const double duration = event.at("EventDuration");
    EXPECT_GT(duration, 0);
    EXPECT_LE(duration, 30);
    events_.emplace_back(time, time + duration);
  }
  void add_curve(const nlohmann::json &curve) {
    EXPECT_EQ(curve.at("ParameterID"), "HapticIntensityControl");
    const auto &points = curve.at("ParameterCurveControlPoints");
    EXPECT_GE(points.size(), 2U);
    EXPECT_LE(points.size(), 16U);
    for (const auto &point : points) {
      const double value = point.at("ParameterValue");
      EXPECT_GE(value, 0);
      EXPECT_LE(value, 1);
      points_.emplace_back(curve.at("Time").get<double>() + point.at("Time").get<double>(), value);
    }
  }

  std::vector<std::pair<double, double>> events_;
  std::vector<std::pair<double, double>> points_; // of all curves
};

TEST(Ahap, TheIntensityIsTheRootOfTheAmplitude) {
  const auto amplitude = [](double time) { return 0.5 + 0.4 * std::sin(3 * time); };
  const Player player(vibration(10, amplitude));
  for (double time = 0.05; time < 9.9; time += 0.01)
    EXPECT_NEAR(player.at(time), amplitude(time), 0.04) << time;
  EXPECT_EQ(player.continuous, 1);
  EXPECT_EQ(player.transient, 0);
}

TEST(Ahap, TheEnergyOfAllActuatorsCounts) {
  std::vector<float> pair;
  for (const float sample : vibration(1, [](double) { return 0.5; })) {
    pair.push_back(0.6F * sample);
    pair.push_back(0.8F * sample);
  }
  EXPECT_NEAR(Player(pair, 2).at(0.5), 0.5, 0.02);
}

TEST(Ahap, LongVibrationsAreSeveralEvents) {
  const Player player(vibration(70, [](double time) { return 0.3 + 0.2 * std::sin(time); }));
  EXPECT_EQ(player.continuous, 3);
  for (double time = 1; time < 69; time += 0.1)
    EXPECT_NEAR(player.at(time), 0.3 + 0.2 * std::sin(time), 0.04) << time;
}

TEST(Ahap, SilenceIsNoEventAndAKnockIsTransient) {
  EXPECT_EQ(Player(vibration(1, [](double) { return 0; })).continuous, 0);
  const Player knock(vibration(1, [](double time) { return time > 0.5 && time < 0.53 ? 0.7 : 0; }));
  EXPECT_EQ(knock.continuous, 0);
  EXPECT_EQ(knock.transient, 1);
  EXPECT_NEAR(knock.strongest * knock.strongest, 0.7, 0.02);
  EXPECT_EQ(Player({}).continuous, 0);
}

} // namespace ahap_test
