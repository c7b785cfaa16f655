// SPDX-License-Identifier: LGPL-2.1-or-later
// The loop with reliefs: what is felt of them and of the motion, and when there is silence.
#include "counted-allocations.hpp"
#include "loop-fixture.hpp"
#include "touched-surface.hpp"

#include <memory>

namespace haptic_loop_touch_test {

using haptic::TouchMode;
using test::kMs;

class TouchingLoop : public test::OnEachDevice<test::Loop> {
protected:
  // The loop outlives the pool here, and must have given everything back.
  void TearDown() override {
    loop_.prepare({});
    ticks(1);
  }
  void open_touching(TouchMode mode, const std::string &hand) {
    open(hand);
    haptic::LoopSettings settings;
    settings.touch = mode;
    loop_.set_settings(settings);
    play();
  }
  void submit(const haptic::ReliefField &relief) {
    auto field = pool_->acquire();
    *field = relief;
    loop_.submit(haptic::TimedRelief{std::move(field)});
  }
  // A source of 100 reliefs and samples a second.
  void touch_for(const haptic::ReliefField &relief, int ms, float vx = 0) {
    for (int i = 0; i < ms; i += 10) {
      submit(relief);
      if (vx != 0)
        loop_.submit(test::moving(vx, 0), now_);
      ticks(10);
    }
  }
  spidar::Vector3 force() const { return loop_.wrench().force; }

  std::unique_ptr<haptic::ReliefPool> pool_ = std::make_unique<haptic::ReliefPool>();
  haptic::ReliefField plane_ = test::relief_of(test::flat(0.003));
};

INSTANTIATE_TEST_SUITE_P(Devices, TouchingLoop, testing::ValuesIn(test::kLoopDevices),
                         [](const auto &of) { return of.param; });

TEST_P(TouchingLoop, TheStiffestSurfaceIsAsStiffAsTheDeviceHolds) {
  open_touching(TouchMode::surface, "hold:0,0,0");
  haptic::LoopSettings settings;
  settings.touch = TouchMode::surface;
  settings.law_settings.max_force = 5;
  settings.slew_rate = 1000; // N/s: follows any of them
  settings.continuous_force = 0;
  loop_.set_settings(settings);
  touch_for(test::relief_of(test::flat(0.003), 1e5), 2000);
  const double stiffness = on_arm_ ? 3000 : 200; // N/m
  // Against the 1000 N/m of the hand.
  EXPECT_NEAR(force().z(), stiffness * 0.003 * 1000 / (1000 + stiffness), 0.05);
}

TEST_P(TouchingLoop, AHandBeneathASurfaceIsPushedOutOfIt) {
  open_touching(TouchMode::surface, "hold:0,0,0");
  touch_for(plane_, 1000, 100);
  // 200 N/m against the 1000 N/m of the hand, and no motion.
  EXPECT_NEAR(force().z(), 200 * 0.003 * 1000 / 1200, 0.01);
  EXPECT_NEAR(force().head<2>().norm(), 0, 0.005);
}

// Its hand may have sunk deep meanwhile, and has put nothing in.
TEST_P(TouchingLoop, AfterTheGuardianTookTheForceTheSurfaceBeginsAtTheHand) {
  open_touching(TouchMode::surface, "hold:0,0,0");
  touch_for(plane_, 1000);
  EXPECT_GT(force().z(), 0.4);
  mishaps_->let_go = true;
  touch_for(plane_, 2000);
  // Freed, the hand went on by the half millimetre by which the surface had held it up.
  EXPECT_LT(force().z(), 0.1);
}

// A hold has left the surface at the hand.
TEST_P(TouchingLoop, ALostReplyLiftsNoHandThatIsBeneathTheSurface) {
  open_touching(TouchMode::surface, "hold:0,0,0");
  touch_for(plane_, 1000);
  mishaps_->let_go = true;
  touch_for(plane_, 500);
  mishaps_->cut = true;
  ticks(1);
  mishaps_->cut = false;
  touch_for(plane_, 1000);
  EXPECT_LT(force().z(), 0.1);
}

TEST_P(TouchingLoop, AMotionThatEndsBesideASurfaceFadesWhateverTheSlewRate) {
  open_touching(TouchMode::surface_and_motion, "hold:0,0,0");
  haptic::LoopSettings settings;
  settings.touch = TouchMode::surface_and_motion;
  settings.slew_rate = 0.5; // N/s
  loop_.set_settings(settings);
  touch_for(plane_, 2000, 100);
  ASSERT_GT(force().x(), 0.4);
  touch_for(plane_, 250); // stale after 100 ms
  EXPECT_NEAR(force().head<2>().norm(), 0, 0.005);
  EXPECT_GT(force().z(), 0.01); // at this slew rate a surface is soft
}

TEST_P(TouchingLoop, SurfaceAndMotionAddUp) {
  open_touching(TouchMode::surface_and_motion, "hold:0,0,0");
  touch_for(plane_, 1000, 100);
  EXPECT_NEAR(force().z(), 200 * 0.003 * 1000 / 1200, 0.01);
  EXPECT_NEAR(force().x(), 0.5, 0.01);
}

TEST_P(TouchingLoop, WithoutTouchReliefsAreFeltAsNothing) {
  open_touching(TouchMode::off, "hold:0,0,0");
  touch_for(plane_, 300);
  EXPECT_TRUE(loop_.silent());
}

TEST_P(TouchingLoop, AFilmThatLosesItsDepthFadesAndTheMotionStays) {
  open_touching(TouchMode::surface, "hold:0,0,0");
  touch_for(plane_, 500);
  ticks(300);
  EXPECT_TRUE(loop_.silent());

  open_touching(TouchMode::surface_and_motion, "hold:0,0,0");
  touch_for(plane_, 500, 100);
  play_motion(100, 0, 300);
  EXPECT_NEAR(force().z(), 0, 1e-9);
  EXPECT_NEAR(force().x(), 0.5, 0.01);
}

TEST_P(TouchingLoop, AHandThatATouchBeginsUnderIsNotThrown) {
  open_touching(TouchMode::surface, "free");
  touch_for(test::relief_of(test::flat(0.02)), 1500);
  EXPECT_FALSE(is_held(haptic::kHoldOverspeed));
  EXPECT_LE(force_max(), 1);
}

TEST_P(TouchingLoop, MillimetresTakenForMetresAreNoSurface) {
  open_touching(TouchMode::surface, "hold:0,0,0");
  touch_for(test::relief_of(test::flat(0.8)), 500);
  EXPECT_TRUE(loop_.silent());
}

TEST_P(TouchingLoop, AFlushDiscardsTheSurface) {
  open_touching(TouchMode::surface, "hold:0,0,0");
  touch_for(plane_, 500);
  loop_.drop_samples();
  ticks(60);
  EXPECT_TRUE(loop_.silent());
}

TEST_P(TouchingLoop, AFlushOfTheReliefsAloneDiscardsThemAndTheMotionStays) {
  open_touching(TouchMode::surface_and_motion, "hold:0,0,0");
  plane_.interval = 500 * kMs; // it stays for 1.5 s
  touch_for(plane_, 500, 100);
  ASSERT_GT(force().z(), 0.4);
  submit(plane_); // on its way
  loop_.drop_reliefs();
  for (int ms = 0; ms < 100; ms += 10) {
    loop_.submit(test::moving(100, 0), now_);
    ticks(10);
    EXPECT_FALSE(loop_.reasons() & haptic::kHoldFlushing);
  }
  EXPECT_NEAR(force().z(), 0, 1e-9);
  EXPECT_NEAR(force().x(), 0.5, 0.01);
}

TEST_P(TouchingLoop, WhileItTouchesTheRegionHasItsOwnSize) {
  open_touching(TouchMode::surface, "hold:0,0,0.5");
  ticks(10);
  EXPECT_EQ(loop_.hand().region_z, 0);
  open_touching(TouchMode::off, "hold:0,0,0.5");
  ticks(10);
  EXPECT_FALSE(loop_.hand().region_z);
}

TEST_P(TouchingLoop, TakesNothingFromTheHeap) {
  open_touching(TouchMode::surface_and_motion, "circle:0.5,1");
  plane_.interval = 1000 * kMs;
  touch_for(plane_, 100, 100);
  plane_.cells[0].height = 0.004F;
  submit(plane_);
  const long before = test::allocations;
  for (int ms = 0; ms < 500; ++ms) {
    ticks(1);
    ASSERT_GT(force().z(), 0) << ms; // it touches all the time
  }
  EXPECT_EQ(test::allocations, before);
}

} // namespace haptic_loop_touch_test
