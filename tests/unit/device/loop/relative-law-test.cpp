// SPDX-License-Identifier: LGPL-2.1-or-later
// The laws that know the hand's motion, in closed loop: a light grip on the real strings over a
// still frame. What a tap begins must come to rest.
#include "loop-fixture.hpp"
#include "model/drive-scale.hpp"
#include "model/string-kinematics.hpp"

#include <algorithm>
#include <ostream>
#include <random>

namespace {

using haptic::HapticLoop;
using spidar::Vector3;
using test::kMs;

struct Hand {
  double mass;      // kg, with the grip
  double damping;   // N·s/m
  double stiffness; // N/m, to where it began
};

// Counts from the geometry's encoders, forces from its strings; the orientation is held.
class HeldGrip final : public spidar::Controller {
public:
  HeldGrip(const spidar::Geometry &geometry, const Hand &hand) : geometry_(geometry), hand_(hand) {}

  void set_time(std::int64_t now) noexcept override {
    elapsed_ = now_ ? static_cast<double>(now - *now_) * 1e-9 : 0;
    now_ = now;
  }
  bool exchange(const spidar::DacWords &words, spidar::Counts &counts) noexcept override {
    constexpr int kSubsteps = 8;
    for (int i = 0; i < kSubsteps; ++i)
      advance(elapsed_ / kSubsteps);
    words_ = words;
    counts = counts_at(position_);
    return true;
  }
  bool home(spidar::Counts &counts) const noexcept override {
    counts = counts_at(Vector3::Zero());
    return true;
  }
  std::string description() const override { return "a held grip"; }

  Vector3 tap = Vector3::Zero(); // N

private:
  void advance(double dt) noexcept {
    spidar::Tensions tensions;
    for (std::size_t i = 0; i < spidar::kStrings; ++i)
      tensions[static_cast<Eigen::Index>(i)] = spidar::tension_of_word(geometry_, i, words_[i]);
    const auto strings =
        spidar::string_kinematics(geometry_, {position_, spidar::Matrix3::Identity()});
    const Vector3 force = spidar::realised_wrench(strings.pull, tensions).force + tap -
                          hand_.stiffness * (position_ - kStart) - hand_.damping * velocity_;
    velocity_ += dt / hand_.mass * force;
    position_ += dt * velocity_;
    constexpr double kFrame = 0.045; // m, half the room between the exit points
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(position_[axis]) > kFrame) {
        position_[axis] = std::copysign(kFrame, position_[axis]);
        velocity_[axis] = 0;
      }
  }
  spidar::Counts counts_at(const Vector3 &position) const noexcept {
    const auto lengths = spidar::string_lengths(geometry_, {position, spidar::Matrix3::Identity()});
    spidar::Counts counts;
    for (std::size_t i = 0; i < counts.size(); ++i)
      counts[i] = static_cast<std::int32_t>(
          std::lround(lengths[static_cast<Eigen::Index>(i)] / geometry_.metres_per_count[i]));
    return counts;
  }

  static inline const Vector3 kStart{0.0031, 0.0017, -0.0009}; // m: off the centre, on no count
  spidar::Geometry geometry_;
  Hand hand_;
  spidar::DacWords words_{};
  Vector3 position_ = kStart;
  Vector3 velocity_ = Vector3::Zero();
  std::optional<std::int64_t> now_; // ns
  double elapsed_ = 0;              // s
};

struct Case {
  const char *geometry;
  const char *law;
  double alpha;     // s/px
  double max_force; // N
  double rate;      // Hz
  int late = 0;     // ms, at most, of one tick in ten

  friend void PrintTo(const Case &c, std::ostream *out) {
    *out << c.geometry << ", " << c.law << ", alpha " << c.alpha << ", " << c.max_force << " N, "
         << c.rate << " Hz, late by up to " << c.late << " ms";
  }
};

std::size_t index_of(const std::string &law) {
  const auto laws = haptic::force_laws();
  return static_cast<std::size_t>(
      std::ranges::find_if(laws, [&](const auto &info) { return law == info.name; }) -
      laws.begin());
}

// N, peak to peak along x in the last 2 of 6 s. The tap lasts 0.02 s.
double unrest(const Case &c, const Hand &hand, double tap) {
  const spidar::Geometry geometry = spidar::load_geometry(c.geometry);
  auto held = std::make_unique<HeldGrip>(geometry, hand);
  HeldGrip &grip = *held;
  spidar::Device device(std::move(held), geometry, 1 / c.rate);
  HapticLoop loop;
  haptic::LoopSettings settings;
  settings.law = index_of(c.law);
  settings.law_settings.alpha = c.alpha;
  settings.law_settings.max_force = c.max_force;
  settings.continuous_force = 0;
  loop.set_settings(settings);
  loop.prepare({.device = &device, .rate = c.rate});
  loop.unhold(haptic::kHoldClosed | haptic::kHoldPaused);

  const auto period = static_cast<std::int64_t>(1e9 / c.rate);
  std::int64_t now = kMs;
  std::int64_t sampled = 0;
  double least = 0;
  double most = 0;
  std::mt19937 random(3);
  const std::int64_t begin = now;
  for (double time = 0; time < 6; time = static_cast<double>(now - begin) * 1e-9) {
    grip.tap = time >= 0.5 && time < 0.52 ? Vector3(tap / 0.02, 0, 0) : Vector3::Zero();
    if (now - sampled >= 33 * kMs) {
      loop.submit(test::moving(0, 0), now);
      sampled = now;
    }
    const std::int64_t late =
        c.late > 0 && random() % 10 == 0 ? static_cast<std::int64_t>(random() % c.late) * kMs : 0;
    now += period + late;
    loop.tick(now - late, now);
    const double force = loop.wrench().force.x();
    if (time < 4)
      least = most = force;
    least = std::min(least, force);
    most = std::max(most, force);
  }
  return most - least;
}

class RelativeLaw : public ::testing::TestWithParam<Case> {};

TEST_P(RelativeLaw, OverAStillFrameATapOnALightHandComesToRest) {
  for (const Hand &hand :
       {Hand{0.1, 0.5, 0}, Hand{0.1, 0.5, 20}, Hand{0.1, 0.5, 300}, Hand{1, 8, 300}})
    for (const double tap : {0.01, 0.1}) // N·s
      EXPECT_LE(unrest(GetParam(), hand, tap), 0.05)
          << hand.mass << " kg, " << hand.damping << " N·s/m, " << hand.stiffness << " N/m, " << tap
          << " N·s";
}

INSTANTIATE_TEST_SUITE_P(Cases, RelativeLaw,
                         testing::Values(Case{"spidar-g6x3r", "drag", 0.01, 1, 1000},
                                         Case{"spidar-g6x3r", "drag", 0.04, 5, 1000},
                                         Case{"spidar-g6x3r", "drag", 0.04, 5, 2000},
                                         Case{"spidar-g6x3r", "drag", 0.04, 5, 200},
                                         Case{"spidar-g6x3r", "drag", 0.04, 5, 100},
                                         Case{"spidar-g6x3r", "drag", 0.04, 5, 1000, 10},
                                         Case{"spidar-g6x4", "drag", 0.04, 5, 1000},
                                         Case{"spidar-g6x5r", "drag", 0.04, 5, 1000},
                                         Case{"spidar-g6x3r", "inertial", 0.04, 1, 1000},
                                         Case{"spidar-g6x3r", "inertial", 0.04, 5, 1000},
                                         Case{"spidar-g6x3r", "inertial", 0.04, 5, 1000, 10},
                                         Case{"spidar-g6x4", "inertial", 0.04, 5, 1000},
                                         Case{"spidar-g6x5r", "inertial", 0.04, 5, 1000}));

} // namespace
