// SPDX-License-Identifier: LGPL-2.1-or-later
// The hand that the tests of the closed loop hold the grip with is itself what it says.
#include "loop-in-hand.hpp"

#include <gtest/gtest.h>
#include <numbers>

namespace test::hand_on_strings_test {

using spidar::Vector3;

const Vector3 kStart(0.005, 0.002, -0.003);

class OnStrings : public ::testing::TestWithParam<std::string> {
protected:
  void exchange(int times = 1) {
    for (int i = 0; i < times; ++i) {
      hand_.set_time(now_ += LoopInHand::kMs);
      ASSERT_TRUE(hand_.exchange(words_, counts_));
    }
  }
  void go_to(const Vector3 &goal) {
    hand_.goal = goal;
    hand_.speed = 0.3;
    while (hand_.target != goal)
      exchange();
  }

  const spidar::Geometry &geometry_ = builtin_geometry(GetParam());
  HandOnStrings hand_{geometry_, {0.4, 0, 300}, kStart};
  std::int64_t now_ = 0; // ns
  spidar::DacWords words_{};
  spidar::Counts counts_{};
};

INSTANTIATE_TEST_SUITE_P(Builtin, OnStrings, testing::ValuesIn(spidar::builtin_geometries()),
                         [](const auto &of) {
                           std::string name = of.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(OnStrings, StringsOfConstantTensionDoNoWorkOnAClosedPath) {
  for (std::size_t i = 0; i < words_.size(); ++i)
    words_[i] = spidar::word_of_tension(geometry_, i, 0.4 + 0.3 * static_cast<double>(i));
  hand_.leads = true;
  exchange(2);
  go_to({0.02, -0.01, 0.015});
  EXPECT_GT(std::abs(hand_.work()), 1e-3);
  go_to({-0.01, 0.02, -0.02});
  go_to(kStart);
  EXPECT_NEAR(hand_.work(), 0, 1e-12);
}

TEST_P(OnStrings, AMassOnASpringSwingsAtItsFrequencyAndKeepsItsEnergy) {
  hand_.target = hand_.goal = Vector3::Zero();
  int turns = 0;
  double first = 0;
  double last = 0;
  for (double before = kStart.x(); now_ < 10'000 * LoopInHand::kMs; before = hand_.position().x()) {
    exchange();
    if (before < 0 || hand_.position().x() >= 0)
      continue;
    last = static_cast<double>(now_) * 1e-9;
    first = turns++ == 0 ? last : first;
  }
  EXPECT_NEAR((turns - 1) / (last - first), std::sqrt(300 / 0.4) / (2 * std::numbers::pi), 0.01);
  EXPECT_NEAR(0.2 * hand_.velocity().squaredNorm() + 150 * hand_.position().squaredNorm(),
              150 * kStart.squaredNorm(), 0.02 * 150 * kStart.squaredNorm());
}

TEST_P(OnStrings, AHandThatTurnsBalancesTheTorqueOfTheStrings) {
  hand_.turning_hand.emplace();
  hand_.leads = true;
  for (std::size_t i = 0; i < words_.size(); ++i)
    words_[i] = spidar::word_of_tension(geometry_, i, i % 2 == 0 ? 1 : 0.5);
  exchange(2000);
  const Eigen::AngleAxisd turned(hand_.rotation());
  EXPECT_NEAR((hand_.wrench().torque - 1.5 * turned.angle() * turned.axis()).norm(), 0, 1e-6);
}

TEST_P(OnStrings, TheDeviceSeesTheGripWithinACount) {
  const double count = std::abs(geometry_.metres_per_count[0]);
  LoopInHand at({.geometry = GetParam(), .start = kStart});
  at.hand().leads = true;
  at.wait(0.2);
  EXPECT_LE((at.device().state().pose.position - kStart).norm(), count);
  at.on_strings().slip[3] = 100;
  at.wait(0.2);
  EXPECT_GT((at.device().state().pose.position - kStart).norm(), 10 * count);
}

TEST_P(OnStrings, TheForceOnTheGripIsTheOneThatIsCommanded) {
  LoopInHand at({.geometry = GetParam(), .start = kStart});
  at.hand().leads = true;
  at.film = Vector3(1e4, 0, 0);
  at.wait(0.5);
  EXPECT_NEAR(at.force().x(), 1, 0.01);
  EXPECT_LE((at.hand().wrench().force - at.force()).norm(), 0.02); // digits of eight motors
}

} // namespace test::hand_on_strings_test
