// SPDX-License-Identifier: LGPL-2.1-or-later
// Ten thousand ticks: they fail for no reason, and the pose is right. Their times are reported.
#include "direct-fixture.hpp"
#include "loop-priority.hpp"
#include "loop/haptic-loop.hpp"
#include "report-line.hpp"

#include <algorithm>
#include <cstdlib>
#include <Eigen/Geometry>
#include <numbers>
#include <spidar/simulator.hpp>

namespace tick_test {

using namespace test;

class Ticks : public DirectlyOnBusOf {};
INSTANTIATE_TEST_SUITE_P(Both, Ticks, ::testing::Values(Model::simple, Model::sh4), name_of_model);

double microseconds(Clock::duration time) {
  return std::chrono::duration<double, std::micro>(time).count();
}

double percentile(std::vector<double> values, double share) {
  const auto n = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + n, values.end());
  return values[static_cast<std::size_t>(n)];
}

/// Duration of each tick of the loop in µs, force law and safety chain included.
std::vector<double> timed_ticks(spidar::Device &device, int ticks) {
  constexpr std::int64_t kPeriod = 1'000'000; // ns
  haptic::HapticLoop loop;
  loop.prepare({.device = &device});
  loop.unhold(haptic::kHoldClosed | haptic::kHoldPaused);
  haptic::MotionSample sample;
  sample.velocity_x = 300;
  sample.velocity_y = -100;
  sample.confidence = 1;
  sample.interval = 33 * kPeriod;
  sample.frame_width = 352;
  sample.frame_height = 288;
  std::vector<double> taken;
  const AsTheLoop priority;
  for (std::int64_t tick = 1; tick <= ticks; ++tick) {
    if (tick % 33 == 1)
      loop.submit(sample, tick * kPeriod);
    const auto begin = Clock::now();
    loop.tick(tick * kPeriod, tick * kPeriod);
    taken.push_back(microseconds(Clock::now() - begin));
  }
  EXPECT_EQ(loop.statistics().device_faults, 0U);
  EXPECT_GT(loop.wrench().force.norm(), 0.3);
  return taken;
}

// Fewer for a sanitizer that looks at each call into libusb.
int wanted_ticks() {
  const char *wanted = std::getenv("FEELING_WIND_TICKS");
  return wanted ? std::atoi(wanted) : 10'000;
}

// The times include libusb and the emulated unit with its plant.
TEST_P(Ticks, AreAllAnsweredAndGiveTheForce) {
  plug(GetParam(), 0);
  const auto device = open_device();
  const std::vector<double> taken = timed_ticks(*device, wanted_ticks());
  report("tick-p50-us", percentile(taken, 0.5));
  report("tick-p99-us", percentile(taken, 0.99));
}

/// Repeats the recorded counts of a simulated controller, which takes no time.
class Playback final : public spidar::Controller {
public:
  Playback() {
    const spidar::Geometry geometry = spidar::load_geometry(spidar::kDefaultGeometry);
    spidar::Simulator simulator(geometry, spidar::parse_hand_script("circle:0.8,1"));
    simulator.home(home_);
    for (spidar::Counts &counts : recorded_)
      simulator.exchange({}, counts);
  }
  bool exchange(const spidar::DacWords &, spidar::Counts &counts) noexcept override {
    counts = recorded_[next_++ % recorded_.size()];
    return true;
  }
  bool home(spidar::Counts &counts) const noexcept override {
    counts = home_;
    return true;
  }
  std::string description() const override { return "a playback"; }

private:
  std::array<spidar::Counts, 1000> recorded_{}; // a full circle
  spidar::Counts home_{};
  std::size_t next_ = 0;
};

TEST(OurPart, OfATickIsMeasuredWithoutUsb) {
  spidar::Device device(std::make_unique<Playback>(),
                        spidar::load_geometry(spidar::kDefaultGeometry));
  const std::vector<double> taken = timed_ticks(device, 10'000);
  report("own-part-p50-us", percentile(taken, 0.5));
  report("own-part-p99-us", percentile(taken, 0.99));
}

TEST_P(Ticks, ThePoseComesThroughTheCountsWithin50MicrometresAndATenthOfADegree) {
  plug(GetParam(), 0);
  const auto device = open_device();
  std::int64_t now = 0;      // ns: the unit moves 1 ms for each question
  double worst_position = 0; // m
  double worst_angle = 0;    // degrees
  for (const spidar::Vector3 &place : {spidar::Vector3{0.8, 0, 0},
                                       {0, -0.7, 0.3},
                                       {-0.5, 0.6, -0.6},
                                       {0.9, 0.9, 0.9},
                                       {-0.9, -0.9, 0.2}}) {
    for (const double torque : {-0.02, 0.0, 0.02}) {
      unit_->move_hand(place);
      for (int tick = 0; tick < 400; ++tick) {
        ASSERT_TRUE(device->exchange(now += 1'000'000));
        device->command({{0.2, 0, 0}, {torque, torque, -torque}});
      }
      ASSERT_TRUE(device->state().valid);
      const spidar::Pose seen = device->state().pose;
      const spidar::Pose truth = unit_->pose();
      const Eigen::AngleAxisd turn(spidar::Matrix3(truth.rotation.transpose() * seen.rotation));
      worst_position = std::max(worst_position, (seen.position - truth.position).norm());
      worst_angle = std::max(worst_angle, std::abs(turn.angle()) * 180 / std::numbers::pi);
    }
  }
  EXPECT_LE(worst_position, 0.00005);
  EXPECT_LE(worst_angle, 0.1);
  report("pose-error-mm", worst_position * 1e3);
  report("pose-error-degrees", worst_angle);
}

} // namespace tick_test
