// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/force-defaults.hpp"
#include "touched-surface.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <spidar/machine.hpp>
#include <string>

namespace contact_law_test {

using haptic::Contact;
using haptic::ContactLaw;
using haptic::ReliefField;
using spidar::Vector3;
using test::kTick;

// On each device, surfaces as stiff as it holds.
class ContactLaws : public ::testing::TestWithParam<test::HandModel> {
protected:
  ReliefField relief_of(const test::Shape &height, double friction = 0) const {
    return test::relief_of(height, stiffness_, friction);
  }
  // Leads the hand in small steps along a line, then lets it rest.
  Contact led(ContactLaw &law, const ReliefField &relief, const Vector3 &from,
              const Vector3 &to) const {
    constexpr int kSteps = 400;
    Contact contact;
    for (int i = 0; i <= kSteps + 20; ++i) {
      const double share = std::min(1.0, static_cast<double>(i) / kSteps);
      contact = law.step(test::surface_of(relief), from + share * (to - from), limits_, kTick);
    }
    return contact;
  }
  Contact pressed(const ReliefField &relief, const Vector3 &to, const Vector3 &from) const {
    ContactLaw law;
    return led(law, relief, from, to);
  }
  void expect_force(const Contact &contact, double depth, const Vector3 &normal) const {
    ASSERT_TRUE(contact.touches);
    EXPECT_NEAR(contact.force.norm(), stiffness_ * depth, 0.02 * stiffness_ * depth);
    EXPECT_LE(test::degrees_between(contact.force, normal), 3);
  }

  // N·s/m, as docs/force.md#touch says, with ticks on time.
  double damping() const {
    const double of_speed = 0.75 * limits_.device.most_resistance(limits_.longest_dt);
    return std::max(0.005 * stiffness_, std::min(0.0075 * stiffness_, of_speed));
  }

  const double stiffness_ = GetParam().stiffest(); // N/m
  const haptic::ContactLimits limits_{.device = *GetParam().device,
                                      .slew_rate = GetParam().slew_rate()};
};

INSTANTIATE_TEST_SUITE_P(Devices, ContactLaws, testing::Values(test::kStiff, test::kStiffOnArm),
                         [](const auto &of) { return of.param.name; });

TEST_P(ContactLaws, APlaneAnswersWithStiffnessTimesDepth) {
  const ReliefField relief = relief_of(test::flat(0.002));
  for (const double depth : {0.0005, 0.001, 0.003, 0.005}) {
    SCOPED_TRACE(depth);
    expect_force(pressed(relief, {0.004, -0.003, 0.002 - depth}, {0.004, -0.003, 0.01}), depth,
                 {0, 0, 1});
  }
}

TEST_P(ContactLaws, ARampAnswersAlongItsNormal) {
  for (const double slope : {0.2, 0.577, 1.0}) {
    SCOPED_TRACE(slope);
    const ReliefField relief =
        relief_of([slope](double x, double y) { return slope * (0.8 * x + 0.6 * y); });
    const Vector3 normal = Vector3(-0.8 * slope, -0.6 * slope, 1).normalized();
    expect_force(pressed(relief, -0.002 * normal, 0.01 * normal), 0.002, normal);
  }
}

TEST_P(ContactLaws, ASphereAnswersAlongItsRadius) {
  constexpr double kRadius = 0.03; // m
  const ReliefField relief = relief_of([](double x, double y) {
    return std::sqrt(std::max(kRadius * kRadius - x * x - y * y, 0.0)) - 0.02;
  });
  const Vector3 centre(0, 0, -0.02);
  for (const double tilt : {0.0, 10.0, 20.0, 30.0})
    for (const double round : {0.0, 37.0, 200.0}) {
      SCOPED_TRACE(std::to_string(tilt) + "°, " + std::to_string(round) + "°");
      const double t = tilt * std::numbers::pi / 180;
      const double r = round * std::numbers::pi / 180;
      const Vector3 radius(std::sin(t) * std::cos(r), std::sin(t) * std::sin(r), std::cos(t));
      expect_force(
          pressed(relief, centre + (kRadius - 0.002) * radius, centre + 1.2 * kRadius * radius),
          0.002, radius);
    }
}

Vector3 nearest_on(const ReliefField &relief, const Vector3 &hand) {
  const auto surface = test::surface_of(relief);
  Vector3 nearest = Vector3::Constant(1);
  for (double x = -0.008; x <= 0.008; x += 2e-5) {
    const Vector3 place(x, hand.y(), surface.at(x, hand.y()).height);
    if ((place - hand).norm() < (nearest - hand).norm())
      nearest = place;
  }
  return nearest;
}

TEST_P(ContactLaws, AStepAnswersOnBothLevelsAndAtItsWall) {
  const ReliefField relief = relief_of([](double x, double) { return x < 0 ? 0 : 0.002; });
  expect_force(pressed(relief, {-0.004, 0, -0.002}, {-0.004, 0, 0.01}), 0.002, {0, 0, 1});
  expect_force(pressed(relief, {0.004, 0, 0}, {0.004, 0, 0.01}), 0.002, {0, 0, 1});
  // From the lower level into the wall.
  const Vector3 hand(0.0005, 0, 0.0005);
  const Vector3 spring = nearest_on(relief, hand) - hand;
  expect_force(pressed(relief, hand, {-0.004, 0, 0.0005}), spring.norm(), spring);
}

TEST_P(ContactLaws, TheProxyStaysOnTheSideThatTheHandCameFrom) {
  const ReliefField relief =
      relief_of([](double x, double) { return std::abs(x) < 0.003 ? 0.01 : -0.01; });
  const Contact left = pressed(relief, {0.001, 0, 0}, {-0.01, 0, 0});
  EXPECT_LT(left.force.x(), -0.1); // nearer to the other side
  const Contact right = pressed(relief, {-0.001, 0, 0}, {0.01, 0, 0});
  EXPECT_GT(right.force.x(), 0.1);
}

TEST_P(ContactLaws, SlipsAtTheAngleOfFriction) {
  for (const double friction : {0.1, 0.3, 0.7, 1.5}) {
    SCOPED_TRACE(friction);
    const ReliefField relief = relief_of(test::flat(), friction);
    ContactLaw law;
    led(law, relief, {-0.01, 0, 0.002}, {-0.01, 0, -0.002});
    const Vector3 stuck = law.contact().proxy;
    double slips_at = 0;
    for (double x = 0; x < 0.006; x += 1e-6) {
      const auto &now = law.step(test::surface_of(relief), {-0.01 + x, 0, -0.002}, limits_, kTick);
      const double angle = test::degrees_between(now.force, {0, 0, 1});
      if (now.proxy == stuck)
        slips_at = angle;
      else
        ASSERT_NEAR(angle, slips_at, 1); // and keeps it
    }
    EXPECT_NEAR(slips_at, std::atan(friction) * 180 / std::numbers::pi, 1);
    EXPECT_NE(law.contact().proxy, stuck);
  }
}

TEST_P(ContactLaws, RestsOnARampFlatterThanTheAngleOfFriction) {
  for (const double slope : {0.35, 0.45}) {
    const ReliefField relief = relief_of([slope](double x, double) { return slope * x; }, 0.4);
    ContactLaw law;
    const Contact contact = led(law, relief, {0, 0, 0.002}, {0, 0, -0.002});
    if (slope < 0.4)
      EXPECT_EQ(contact.proxy.x(), 0);
    else
      EXPECT_LT(contact.proxy.x(), -1e-6);
  }
}

TEST_P(ContactLaws, FeelsNoStifferSurfaceThanTheDeviceCanHold) {
  EXPECT_DOUBLE_EQ(haptic::stiffest({.device = test::kSpidar}), haptic::kStiffestTouch)
      << "of haptic-track compare";
  for (const spidar::DeviceLimits &device : {test::kSpidar, test::kArm})
    EXPECT_DOUBLE_EQ(haptic::stiffest({.device = device, .longest_dt = 0.008}),
                     spidar::stiffest_touch(device, 0.008));
  EXPECT_DOUBLE_EQ(haptic::stiffest({.device = test::kSpidar, .slew_rate = 5}), 50);
  EXPECT_DOUBLE_EQ(
      haptic::stiffest({.device = test::kSpidar, .slew_rate = 1000, .longest_dt = 0.01}), 20);
  const ReliefField relief = test::relief_of(test::flat(), 1e5);
  expect_force(pressed(relief, {0, 0, -0.001}, {0, 0, 0.01}), 0.001, {0, 0, 1});
}

TEST_P(ContactLaws, LateTicksTakeMoreOfItsSpringThanOfItsDamper) {
  haptic::ContactLimits late = limits_;
  late.longest_dt = 0.01;
  const ReliefField relief = relief_of(test::flat(0.002));
  const auto damping_at = [&](const haptic::ContactLimits &limits) {
    ContactLaw law;
    for (const double z : {0.003, 0.001})
      EXPECT_EQ(law.step(test::surface_of(relief), {0, 0, z}, limits, kTick).touches, z < 0.002);
    return law.damping();
  };
  const double on_time = damping_at(limits_);
  EXPECT_NEAR(on_time, damping(), 1e-9);
  EXPECT_LT(haptic::stiffest(late), stiffness_ / 2);
  const double most = late.device.most_resistance(late.longest_dt);
  EXPECT_GE(damping_at(late), std::min(on_time, 0.7 * most));
  EXPECT_LE(damping_at(late), most);
}

TEST_P(ContactLaws, WithoutASurfaceThereIsNoForce) {
  ReliefField holes = relief_of(test::flat(0.005));
  for (auto &cell : holes.cells)
    cell = {};
  EXPECT_FALSE(pressed(holes, {0, 0, 0}, {0, 0, 0.01}).touches);

  // It ends under the hand that touches it, and comes back.
  const ReliefField relief = relief_of(test::flat(0.005));
  ContactLaw law;
  led(law, relief, {0, 0, 0.01}, {0, 0, 0.002});
  EXPECT_EQ(law.step(test::surface_of(holes), {0, 0, 0.002}, limits_, kTick).force,
            Vector3::Zero());
  EXPECT_LE(law.step(test::surface_of(relief), {0, 0, 0.002}, limits_, kTick).force.norm(), 1e-9);
}

TEST_P(ContactLaws, AHandThatIsFoundBeneathASurfaceIsLiftedSlowly) {
  const ReliefField relief = relief_of(test::flat(0.02));
  ContactLaw law;
  // N in 1 ms, at 0.1 m/s, of the spring and of the damper, which is whole at 0.5 mm.
  const double most = 0.0001 * (stiffness_ + 0.1 / 0.0005 * damping());
  double before = 0;
  for (int ms = 0; ms < 100; ++ms) {
    const Vector3 force = law.step(test::surface_of(relief), Vector3::Zero(), limits_, kTick).force;
    ASSERT_LE(force.z() - before, 1.0025 * most) << ms;
    before = force.z();
  }
  EXPECT_NEAR(law.contact().proxy.z(), 0.01, 2e-4);
}

TEST_P(ContactLaws, AfterAHoldTheSurfaceBeginsAtTheHandAndDoesNotLiftIt) {
  const ReliefField relief = relief_of(test::flat());
  ContactLaw law;
  led(law, relief, {0, 0, 0.002}, {0, 0, -0.004});
  law.hold();
  EXPECT_TRUE(led(law, relief, {0, 0, -0.004}, {0, 0, -0.004}).force.isZero(1e-9));
  EXPECT_NEAR(led(law, relief, {0, 0, -0.004}, {0, 0, -0.005}).force.z() / stiffness_, 0.001,
              2.5e-5);
  EXPECT_FALSE(led(law, relief, {0, 0, -0.005}, {0, 0, 0.002}).touches);
  expect_force(led(law, relief, {0, 0, 0.002}, {0, 0, -0.001}), 0.001, {0, 0, 1});
}

TEST_P(ContactLaws, OnTheWayOutTheSpringHoldsNoMoreThanTheHandHasPutIn) {
  const ReliefField relief = relief_of(test::flat());
  ContactLaw law;
  led(law, relief, {0, 0, 0.002}, {0, 0, -0.004});
  const Contact contact = law.step(test::surface_of(relief), {0, 0, -0.00399},
                                   {.device = limits_.device,
                                    .slew_rate = limits_.slew_rate,
                                    .energy = stiffness_ * 0.001 * 0.001 / 2},
                                   kTick);
  EXPECT_NEAR(contact.proxy.z(), -0.00299, 1e-5);
  EXPECT_DOUBLE_EQ(contact.energy, stiffness_ * 0.001 * 0.001 / 2);
}

// A ball on a wall, of 14 mm, at x.
test::Shape ball_at(double centre) {
  return [centre](double x, double y) {
    constexpr double kRadius = 0.007;
    const double square = kRadius * kRadius - (x - centre) * (x - centre) - y * y;
    return square > 0 ? -0.002 + std::sqrt(square) : -0.012;
  };
}

// Its flank falls beneath the hand as it leaves.
TEST_P(ContactLaws, ABallThatPassesPullsInByNoMoreThanItsFriction) {
  constexpr double kSpeed = 0.02; // m/s
  for (const double friction : {0.3, 0.8})
    for (const Vector3 &hand : {Vector3(0, 0, -0.004), Vector3(0, 0.002, -0.008),
                                Vector3(0, 0.004, -0.008), Vector3(0, 0.004, 0)}) {
      SCOPED_TRACE(hand.transpose());
      const double share = friction / std::hypot(1, friction);
      ContactLaw law;
      ReliefField from = relief_of(ball_at(-0.02), friction);
      for (int frame = 1; frame <= 60; ++frame) {
        const ReliefField to = relief_of(ball_at(-0.02 + kSpeed * frame / 30), friction);
        for (int ms = 0; ms < 33; ++ms) {
          const Contact contact =
              law.step({from, to, ms / 33.0, test::kHalf}, hand, limits_, kTick);
          ASSERT_GE(contact.force.z(), -share * contact.force.norm() - 1e-4 * stiffness_) << frame;
        }
        from = to;
      }
    }
}

TEST_P(ContactLaws, AHandThatComesFromAHoleBeneathAHighSurfaceIsNotThrown) {
  ReliefField relief = relief_of(test::flat(0.02));
  for (std::size_t i = 0; i < relief.cells.size(); ++i)
    if (i % test::kCells < test::kCells / 2)
      relief.cells[i] = {};
  ContactLaw law;
  double before = 0;
  for (int ms = 0; ms < 200; ++ms) {
    const Vector3 hand(-0.004 + 0.00008 * std::min(ms, 100), 0, 0);
    const Contact &now = law.step(test::surface_of(relief), hand, limits_, kTick);
    ASSERT_LE(now.proxy.z(), 1e-4 * (ms + 1)) << ms; // the surface comes with 0.1 m/s
    before = now.force.norm();
  }
  EXPECT_TRUE(law.contact().touches);
  EXPECT_GT(before / stiffness_, 0.0025);
}

TEST_P(ContactLaws, ANumberThatIsNotFiniteGivesNoForce) {
  const ReliefField relief = relief_of(test::flat(0.02));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  ContactLaw law;
  led(law, relief, {0, 0, 0.03}, {0, 0, 0.018});
  EXPECT_FALSE(law.step(test::surface_of(relief), {kNan, 0, 0}, limits_, kTick).touches);
}

// The energy k d² / 2 of a spring that is held while the relief changes may only rise by the work
// of the surface's own movement.
TEST_P(ContactLaws, AStifferFrameGivesTheHandNoEnergy) {
  const ReliefField soft = test::relief_of(test::flat(), stiffness_ / 4);
  const ReliefField stiff = relief_of(test::flat());
  ContactLaw law;
  led(law, soft, {0, 0, 0.01}, {0, 0, -0.004});
  const double energy = stiffness_ / 4 * 0.004 * 0.004 / 2;
  double most = energy;
  for (int ms = 0; ms < 100; ++ms) {
    const double before = ms ? law.contact().proxy.z() : -0.002; // shortened to k d² as before
    const Contact now = law.step(test::surface_of(stiff), {0, 0, -0.004}, limits_, kTick);
    most += stiffness_ * (now.proxy.z() + 0.004) * (now.proxy.z() - before);
    ASSERT_LE(stiffness_ * std::pow(now.proxy.z() + 0.004, 2) / 2, most * (1 + 1e-9)) << ms;
  }
  EXPECT_NEAR(law.contact().proxy.z(), 0, 1e-9); // it is as stiff as the film says in the end
}

} // namespace contact_law_test
