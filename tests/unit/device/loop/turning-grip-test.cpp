// SPDX-License-Identifier: LGPL-2.1-or-later
// A grip that turns under a torque: a free one stays slow, and a hand that turns it keeps its force
// (docs/force.md#turning). The clock is driven by hand.
#include "loop-fixture.hpp"

#include <algorithm>
#include <cstdlib>
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <numbers>
#include <random>

namespace turning_grip_test {

using haptic::HapticLoop;
using haptic::MotionSample;
using spidar::Pose;
using spidar::Vector3;
using test::kMs;

constexpr float kFullTurn = -1e4F; // rad/s: next to max-torque, about +z

// A grip whose pose a function of time gives, whatever the motors do.
class ScriptedGrip final : public spidar::Controller {
public:
  using Script = std::function<Pose(double)>; // of s
  ScriptedGrip(spidar::Geometry geometry, Script script)
      : geometry_(std::move(geometry)), script_(std::move(script)) {}

  void set_time(std::int64_t now) noexcept override { now_ = now; }
  bool exchange(const spidar::DacWords &, spidar::Counts &counts) noexcept override {
    counts = counts_at(script_(static_cast<double>(now_) * 1e-9));
    return true;
  }
  bool home(spidar::Counts &counts) const noexcept override {
    counts = counts_at({});
    return true;
  }
  std::string description() const override { return "a scripted grip"; }

private:
  spidar::Counts counts_at(const Pose &pose) const noexcept {
    const spidar::StringLengths lengths = string_lengths(geometry_, pose);
    spidar::Counts counts;
    for (std::size_t i = 0; i < counts.size(); ++i)
      counts[i] = static_cast<std::int32_t>(
          std::lround(lengths[static_cast<Eigen::Index>(i)] / geometry_.metres_per_count[i]));
    return counts;
  }

  spidar::Geometry geometry_;
  Script script_;
  std::int64_t now_ = 0; // ns
};

// A hand that holds the grip in the centre until it lets go.
class LettingGo final : public spidar::HandScript {
public:
  explicit LettingGo(double when) : when_(when) {}
  bool target(double time, const Vector3 &, Vector3 &target) const noexcept override {
    target.setZero();
    return time < when_;
  }

private:
  double when_; // s
};

class TurningGrip : public ::testing::TestWithParam<std::string> {
protected:
  void open(std::unique_ptr<spidar::Controller> controller, double max_torque = 0.02) {
    device_ = std::make_unique<spidar::Device>(std::move(controller),
                                               spidar::load_geometry(geometry_name()));
    loop_.prepare({.device = device_.get()});
    loop_.unhold(haptic::kHoldClosed | haptic::kHoldPaused | haptic::kLatches);
    haptic::LoopSettings settings;
    settings.law_settings.max_torque = max_torque;
    loop_.set_settings(settings);
  }
  static std::string geometry_name() {
    const auto *info = ::testing::UnitTest::GetInstance()->current_test_info();
    return info->value_param() ? GetParam() : spidar::kDefaultGeometry;
  }
  static std::unique_ptr<spidar::Simulator> simulated(std::unique_ptr<spidar::HandScript> hand) {
    return std::make_unique<spidar::Simulator>(spidar::load_geometry(geometry_name()),
                                               std::move(hand));
  }
  void tick(float spin, float vx = 0, std::int64_t elapsed = kMs) {
    now_ += elapsed;
    if (now_ - sampled_ >= 10 * kMs) {
      MotionSample sample = test::moving(vx, 0);
      sample.spin = spin;
      loop_.submit(sample, now_);
      sampled_ = now_;
    }
    loop_.tick(now_, now_);
  }
  bool is_let_go() const { return loop_.holds() & haptic::kHoldOverspeed; }

  std::int64_t now_ = 1000 * kMs;
  std::int64_t sampled_ = 0;
  std::unique_ptr<spidar::Device> device_;
  HapticLoop loop_;
};

// The true speed at which a simulated grip turns, rad/s.
class TurningSpeed {
public:
  double next(const Pose &pose) {
    const double angle =
        Eigen::AngleAxisd(spidar::Matrix3(pose.rotation * before_.transpose())).angle();
    before_ = pose.rotation;
    return angle * 1000;
  }

private:
  spidar::Matrix3 before_ = spidar::Matrix3::Identity();
};

using FreeGrip = TurningGrip;
INSTANTIATE_TEST_SUITE_P(Builtin, FreeGrip, testing::ValuesIn(spidar::builtin_geometries()),
                         [](const auto &of) {
                           std::string name = of.param;
                           std::erase(name, '-');
                           return name;
                         });

constexpr double kFastest = 4.9; // rad/s
constexpr double kRest = 0.5;    // rad/s: 1 cm/s at the surface of the grip
constexpr int kRestsAfter = 750; // ms

TEST_P(FreeGrip, TurnsWithAtMost5RadiansPerSecondAndRestsIn750Milliseconds) {
  for (const double max_torque : {0.002, 0.005, 0.01, 0.02, 0.1}) {
    for (const float spin : {kFullTurn, -kFullTurn, 1.0F, -0.3F}) {
      auto simulator = simulated(spidar::parse_hand_script("free"));
      const spidar::Simulator &true_grip = *simulator;
      open(std::move(simulator), max_torque);
      TurningSpeed speed;
      double most = 0; // N·m
      for (int ms = 0; ms < 1500; ++ms) {
        tick(spin);
        const double turning = speed.next(true_grip.pose());
        ASSERT_LE(turning, ms < kRestsAfter ? kFastest : kRest)
            << max_torque << " N·m, spin " << spin << ", after " << ms << " ms";
        most = std::max(most, std::abs(loop_.wrench().torque.z()));
      }
      // A high torque is latched while it still rises.
      ASSERT_GT(most, std::min(0.18 * max_torque, 0.005)) << max_torque << " N·m, spin " << spin;
    }
  }
}

TEST_P(FreeGrip, LetGoUnderTheFullTorqueIsNoFaster) {
  for (const double max_torque : {0.01, 0.015, 0.02}) {
    auto simulator = simulated(std::make_unique<LettingGo>(0.5));
    const spidar::Simulator &true_grip = *simulator;
    open(std::move(simulator), max_torque);
    TurningSpeed speed;
    for (int ms = 0; ms < 2000; ++ms) {
      tick(kFullTurn);
      const double turning = speed.next(true_grip.pose());
      ASSERT_LE(turning, ms < 500 + kRestsAfter ? kFastest : kRest)
          << max_torque << " N·m, " << ms << " ms";
      if (ms == 498) {
        ASSERT_NEAR(loop_.wrench().torque.z(), max_torque, 0.001 * max_torque);
      }
    }
  }
}

TEST_P(FreeGrip, LetGoUnderTheHighestTorqueTurnsWithAtMost20RadiansPerSecond) {
  auto simulator = simulated(std::make_unique<LettingGo>(0.5));
  const spidar::Simulator &true_grip = *simulator;
  open(std::move(simulator), 0.1);
  TurningSpeed speed;
  for (int ms = 0; ms < 2000; ++ms) {
    tick(kFullTurn);
    ASSERT_LE(speed.next(true_grip.pose()), ms < 1250 ? 20 : kRest) << ms;
    if (ms == 498) {
      ASSERT_GT(loop_.wrench().torque.z(), 0.098);
    }
  }
  EXPECT_TRUE(is_let_go());
}

// At sideways force and torque the grip leaves the workspace, where the strings turn it by
// themselves. Its surface is then no faster than the grip as a whole may be.
TEST_P(FreeGrip, UnderForceAndTorqueItsSurfaceIsSlowerThan1MetrePerSecond) {
  auto simulator = simulated(spidar::parse_hand_script("free"));
  const spidar::Simulator &true_grip = *simulator;
  open(std::move(simulator));
  TurningSpeed speed;
  for (int ms = 0; ms < 2000; ++ms) {
    tick(kFullTurn, 1e5F);
    ASSERT_LE(speed.next(true_grip.pose()) * device_->geometry().grip_radius, 1) << ms;
  }
  EXPECT_TRUE(is_let_go());
}

// ---- a hand that turns the grip -----------------------------------------------------------------

// To and fro about z by 0.5 rad, `fastest` in rad/s.
ScriptedGrip::Script twisting(double fastest) {
  constexpr double kAngle = 0.5; // rad
  return [=](double time) {
    Pose pose;
    const double angle = kAngle * std::sin(fastest / kAngle * time);
    pose.rotation = Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix();
    return pose;
  };
}

TEST_F(TurningGrip, AHandThatTurnsAt2AndAHalfRadiansPerSecondKeepsTheTorque) {
  open(std::make_unique<ScriptedGrip>(spidar::load_geometry(geometry_name()), twisting(2.5)));
  double most = 0;
  for (int ms = 0; ms < 5000; ++ms) {
    tick(kFullTurn);
    most = std::max(most, loop_.wrench().torque.z());
    ASSERT_FALSE(is_let_go()) << ms;
  }
  EXPECT_NEAR(most, 0.02, 0.001);
}

TEST_F(TurningGrip, UnderAForceAloneAHandMayTurnTwiceAsFast) {
  open(std::make_unique<ScriptedGrip>(spidar::load_geometry(geometry_name()), twisting(6)));
  for (int ms = 0; ms < 5000; ++ms) {
    tick(0, 1e5F);
    ASSERT_FALSE(is_let_go()) << ms;
  }
  EXPECT_NEAR(loop_.wrench().force.x(), 1, 0.01);
}

TEST_F(TurningGrip, ATurnThatTheTorqueDrivesForFiveMillisecondsIsLatchedUntilArmed) {
  const auto speed = std::make_shared<double>(0); // rad/s; the device ends after this function
  open(std::make_unique<ScriptedGrip>(
      spidar::load_geometry(geometry_name()), [speed, pose = Pose()](double) mutable {
        pose.rotation = Eigen::AngleAxisd(1e-3 * *speed, Vector3::UnitZ()) * pose.rotation;
        return pose;
      }));
  for (int ms = 0; ms < 500; ++ms)
    tick(kFullTurn);
  *speed = 4;
  int latched_after = 0;
  while (!is_let_go() && latched_after < 100) {
    tick(kFullTurn);
    ++latched_after;
  }
  EXPECT_GE(latched_after, 5);
  EXPECT_LE(latched_after, 15);
  *speed = 0;
  for (int ms = 0; ms < 200; ++ms)
    tick(kFullTurn);
  EXPECT_TRUE(loop_.silent());
  EXPECT_EQ(loop_.statistics().overspeeds, 1U);
  loop_.unhold(haptic::kLatches);
  for (int ms = 0; ms < 1000; ++ms)
    tick(kFullTurn);
  EXPECT_NEAR(loop_.wrench().torque.z(), 0.02, 1e-4);
}

// A hand at 0.7 m/s that also turns the grip at 2.5 rad/s under force and torque, one tick in
// twenty up to 19 ms late. LATE_TICKS=1000000 runs the number that is promised.
TEST_F(TurningGrip, LateTicksDoNotMakeAHandThatTurnsTooFast) {
  const char *wanted = std::getenv("LATE_TICKS");
  const int count = wanted ? std::atoi(wanted) : 50'000;
  const auto script = [twist = twisting(2.5)](double time) {
    Pose pose = twist(time);
    const double angle = 28 * time; // 0.7 m/s at 25 mm
    pose.position = 0.025 * Vector3(std::cos(angle), std::sin(angle), 0);
    return pose;
  };
  open(std::make_unique<ScriptedGrip>(spidar::load_geometry(geometry_name()), script));
  std::mt19937 random(6);
  std::uniform_int_distribution<std::int64_t> how_late(1, 19 * kMs);
  std::uniform_int_distribution<int> of_twenty(1, 20);
  double fastest = 0;
  double fastest_turn = 0;
  for (int i = 0; i < count; ++i) {
    tick(kFullTurn, 100, kMs + (of_twenty(random) == 1 ? how_late(random) : 0));
    if (i < 100)
      continue; // the grip did not begin at rest
    fastest = std::max(fastest, device_->state().velocity.norm());
    fastest_turn = std::max(fastest_turn, device_->state().angular_velocity.norm());
  }
  EXPECT_LT(fastest, 0.9);
  EXPECT_LT(fastest_turn, 5);
  EXPECT_EQ(loop_.statistics().overspeeds, 0U);
}

} // namespace turning_grip_test
