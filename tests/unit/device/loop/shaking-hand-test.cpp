// SPDX-License-Identifier: LGPL-2.1-or-later
// The watch that stops a law which shakes the hand: laws without their limit are stopped, and no
// lively hand is. SHAKE_TICKS=1000000 plays the whole draw of lively hands.
#include "device-limits.hpp"
#include "loop-in-hand.hpp"
#include "report-line.hpp"

#include <cstdlib>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <ostream>
#include <random>
#include <utility>

namespace shaking_hand_test {

using haptic::ShakeWatch;
using spidar::Vector3;
using test::Hand;
using test::LoopInHand;

const double kResistance = test::kSpidar.most_resistance(0.001); // N·s/m

haptic::LoopSettings settings_of(const std::string &law, double alpha, double max_force) {
  haptic::LoopSettings settings;
  while (haptic::force_laws()[settings.law].name != law)
    ++settings.law;
  settings.law_settings.alpha = alpha;
  settings.law_settings.max_force = max_force;
  settings.continuous_force = 0;
  return settings;
}

struct Case {
  const char *geometry;
  const char *law;
  double max_force; // N

  friend void PrintTo(const Case &c, std::ostream *out) {
    *out << c.geometry << ", " << c.law << ", " << c.max_force << " N";
  }
};

class Unbounded : public ::testing::TestWithParam<Case> {};

TEST_P(Unbounded, ALawIsStoppedWithinASecondInEachOf27Hands) {
  constexpr double kTap = 0.02; // s
  constexpr double kPush = 0.5; // N
  constexpr double kWithin = 1; // s
  double slowest = 0;           // s
  for (const double mass : {0.1, 0.4, 1.0})
    for (const double damping : {0.5, 3.0, 8.0})
      for (const double stiffness : {0.0, 20.0, 300.0}) {
        SCOPED_TRACE(testing::Message()
                     << mass << " kg, " << damping << " N·s/m, " << stiffness << " N/m");
        LoopInHand held({.geometry = GetParam().geometry,
                         .hand = {mass, damping, stiffness},
                         .start = {0.004, -0.002, 0.001}, // m
                         .settings = settings_of(GetParam().law, 0.04, GetParam().max_force),
                         .bounds_hand = false});
        const double begin = held.time();
        held.hand().push.x() = kPush;
        held.wait(kTap);
        held.hand().push.setZero();
        while (held.loop.statistics().shakes == 0 && held.time() < begin + kWithin)
          held.tick();
        EXPECT_EQ(held.loop.statistics().shakes, 1U);
        slowest = std::max(slowest, held.time() - begin);
        held.wait(0.1);
        EXPECT_TRUE(held.loop.silent());
      }
  test::report("shaking-stopped-s", slowest);
}

INSTANTIATE_TEST_SUITE_P(Laws, Unbounded,
                         testing::Values(Case{spidar::kDefaultGeometry, "drag", 1},
                                         Case{spidar::kDefaultGeometry, "drag", 5},
                                         Case{spidar::kDefaultGeometry, "inertial", 1},
                                         Case{spidar::kDefaultGeometry, "inertial", 5},
                                         Case{test::kArmName, "drag", 1},
                                         Case{test::kArmName, "drag", 12},
                                         Case{test::kArmName, "inertial", 1},
                                         Case{test::kArmName, "inertial", 12}));

// A hand that goes where it likes, or is pushed about, under a film with gusts or a still one.
class LivelyHand {
public:
  LivelyHand(unsigned seed, bool on_arm) : random_(seed), held_(setup(on_arm)) {
    held_.hand().leads = leads_;
    held_.hand().acceleration = one_of({3, 30, 100, 1e9});
    held_.frame = static_cast<std::int64_t>(one_of({16, 33, 40})) * LoopInHand::kMs;
  }

  /// Returns the number of ticks. The hand is never let go for long.
  std::uint64_t play(double seconds) {
    for (const double end = held_.time() + seconds; held_.time() < end;) {
      if (held_.time() >= next_)
        decide();
      const double angle = 2 * std::numbers::pi * gusts_ * held_.time();
      held_.film = {wind_ + gust_ * std::sin(angle), gust_ * std::cos(0.85 * angle), 0};
      held_.tick();
      held_.loop.unhold(haptic::kHoldOverspeed);
    }
    return held_.loop.statistics().ticks;
  }
  const haptic::LoopStatistics &statistics() const { return held_.loop.statistics(); }

private:
  double within(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  double one_of(std::initializer_list<double> values) {
    return *(values.begin() + random_() % values.size());
  }
  Vector3 anywhere(double extent) {
    return {within(-extent, extent), within(-extent, extent), within(-extent, extent)};
  }

  LoopInHand::Setup setup(bool on_arm) {
    const std::vector<std::string> geometries = spidar::builtin_geometries();
    const std::string &strings = geometries[random_() % geometries.size()];
    LoopInHand::Setup setup{.geometry = on_arm ? test::kArmName : strings,
                            .hand = hand_,
                            .pace = {.rate = one_of({500, 1000, 1000, 4000}),
                                     .every = one_of({0, 0, 0, 8}),
                                     .late = one_of({0, 0, 10})},
                            .settings =
                                settings_of(random_() % 2 ? "drag" : "inertial",
                                            one_of({0.01, 0.04, 0.2}), one_of({1, 2.5, 5}))};
    setup.settings.slew_rate = one_of({5, 20, 20, 1000});
    setup.settings.damping = one_of({0, 1, 1});
    return setup;
  }
  void decide() {
    next_ = held_.time() + within(0.02, 0.5);
    if (leads_ || hand_.stiffness > 0) {
      held_.hand().goal = anywhere(0.02);
      held_.hand().speed = within(0.02, fastest_);
    }
    if (!leads_)
      held_.hand().push = within(0, 8) * hand_.mass * anywhere(1);
  }

  std::mt19937 random_;
  const Hand hand_{one_of({0.1, 0.4, 1}), one_of({0.5, 3, 8}), one_of({0, 20, 300})};
  const bool leads_ = random_() % 2 == 0;
  const double fastest_ = one_of({0.1, 0.3, 0.9});     // m/s
  const bool still_ = random_() % 4 == 0;              // the film
  const double wind_ = still_ ? 0 : within(-200, 200); // px/s
  const double gust_ = still_ ? 0 : within(0, 500);    // px/s
  const double gusts_ = within(0.2, 5);                // Hz
  double next_ = 0;                                    // s
  LoopInHand held_;
};

class Bounded : public ::testing::TestWithParam<const char *> {};

INSTANTIATE_TEST_SUITE_P(Devices, Bounded, testing::Values("strings", test::kArmName),
                         [](const auto &device) { return std::string(device.param); });

TEST_P(Bounded, NoLivelyHandIsTakenForAShakingOne) {
  const char *wanted = std::getenv("SHAKE_TICKS");
  const std::uint64_t most = wanted ? std::strtoull(wanted, nullptr, 10) : 100'000;
  std::uint64_t ticks = 0;
  for (unsigned seed = 1001; ticks < most; ++seed) { // none of those that the bounds were tuned on
    LivelyHand hand(seed, GetParam() == std::string(test::kArmName));
    ticks += hand.play(5);
    ASSERT_EQ(hand.statistics().shakes, 0U) << seed;
  }
  test::report("lively-ticks", static_cast<double>(ticks));
}

TEST(ShakeWatch, HalvesFirstAndThenStops) {
  ShakeWatch watch;
  const auto step = [&](double time, double force, double velocity) {
    const double phase = 2 * std::numbers::pi * 15 * time;
    return watch.step({force * std::sin(phase), 0, 0}, {velocity * std::cos(phase), 0, 0},
                      kResistance, 0.001);
  };
  double time = 0; // s
  for (; time < 2; time += 0.001)
    ASSERT_EQ(step(time, 0.2, 0.1), 1) << "2 N·s/m";
  for (; time < 3 && step(time, 1, 0.05) == 1; time += 0.001) {
  }
  EXPECT_LT(time, 2.5);
  EXPECT_FALSE(watch.stops());
  const double halved = time;
  for (; time < 3 && !watch.stops(); time += 0.001)
    ASSERT_EQ(step(time, 1, 0.05), 0.5);
  EXPECT_NEAR(time - halved, 0.25, 0.01);
  for (; time < 5; time += 0.001)
    step(time, 0.1, 0.1);
  EXPECT_FALSE(watch.stops());
  EXPECT_EQ(step(time, 0.1, 0.1), 1) << "calm again";
}

TEST(ShakeWatch, OutlivesANumberThatIsNotFinite) {
  ShakeWatch watch;
  watch.step({std::numeric_limits<double>::quiet_NaN(), 0, 0}, Vector3::Zero(), kResistance, 0.001);
  double share = 1;
  for (double time = 0; time < 1; time += 0.001)
    share = watch.step({std::sin(2 * std::numbers::pi * 15 * time), 0, 0}, Vector3::Zero(),
                       kResistance, 0.001);
  EXPECT_EQ(share, 0.5);
}

TEST(ShakeWatch, LeavesASlowForceAndOneThatNobodyFeels) {
  for (const auto &[force, frequency] : {std::pair{0.5, 0.05}, {0.03, 15.0}}) { // N, Hz
    ShakeWatch watch;
    for (double time = 0; time < 5; time += 0.001) {
      const Vector3 now(force * std::sin(2 * std::numbers::pi * frequency * time), 0, 0);
      ASSERT_EQ(watch.step(now, Vector3::Zero(), kResistance, 0.001), 1) << frequency;
    }
  }
}

} // namespace shaking_hand_test
