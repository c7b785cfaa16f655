// SPDX-License-Identifier: LGPL-2.1-or-later
// A string that slips on its drum, in the hand: the force goes at once, and does not come back
// before a calibration.
#include "loop-in-hand.hpp"

#include <gtest/gtest.h>

namespace slipped_string_test {

constexpr double kSlip = 0.005; // m

class SlippedString : public ::testing::TestWithParam<std::string> {
protected:
  SlippedString() {
    held_.film.x() = 100; // px/s
    held_.wait(1);
  }
  void slip(double metres) {
    const double count = test::builtin_geometry(GetParam()).metres_per_count[2];
    held_.on_strings().slip[2] += static_cast<std::int32_t>(metres / count);
  }
  double force() const { return held_.force().norm(); }

  test::LoopInHand held_{{.geometry = GetParam(), .hand = {.stiffness = 300}}};
};

TEST_P(SlippedString, FadesAtOnceAndReturnsAfterACalibration) {
  ASSERT_GT(force(), 0.4);
  slip(kSlip);
  held_.wait(0.02);
  EXPECT_LT(force(), 0.4);
  EXPECT_TRUE(held_.loop.reasons() & haptic::kHoldSlipped);
  held_.wait(0.05);
  EXPECT_EQ(force(), 0);
  held_.wait(0.25);
  slip(-kSlip);
  held_.wait(1);
  EXPECT_EQ(force(), 0) << "who knows where it is now";
  held_.loop.calibrate();
  held_.wait(1);
  EXPECT_GT(force(), 0.4);
}

TEST_P(SlippedString, ReturnsByItselfAfterAMoment) {
  slip(kSlip);
  held_.wait(0.05);
  slip(-kSlip);
  held_.wait(1);
  EXPECT_GT(force(), 0.4);
}

INSTANTIATE_TEST_SUITE_P(Geometries, SlippedString, testing::ValuesIn(spidar::builtin_geometries()),
                         [](const auto &of) {
                           std::string name = of.param;
                           std::erase(name, '-');
                           return name;
                         });

} // namespace slipped_string_test
