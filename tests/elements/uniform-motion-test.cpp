// SPDX-License-Identifier: LGPL-2.1-or-later
// What a hand feels of frames whose motion is known, from the frame to the force: the elements
// measure, and a loop ticks without a thread. No clock runs.
#include "loop/haptic-loop.hpp"
#include "samples/motion-sample.hpp"
#include "video-harness.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <spidar/device.hpp>
#include <spidar/simulator.hpp>

namespace uniform_motion_test {

using haptic::BufferPtr;
using haptic::HapticLoop;
using haptic::LawSettings;
using spidar::Vector3;
using test::Frame;
using test::Shift;

constexpr int kRate = 30;               // frames a second
constexpr int kTicks = 1000 / kRate;    // a frame
constexpr std::int64_t kMs = 1'000'000; // ns

class UniformMotion : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  void SetUp() override {
    const spidar::Geometry geometry = spidar::load_geometry(spidar::kDefaultGeometry);
    device_ = std::make_unique<spidar::Device>(
        std::make_unique<spidar::Simulator>(geometry, spidar::parse_hand_script("hold:0,0,0")),
        geometry);
  }

  /// The force of each tick while a hand in the middle feels so many frames.
  std::vector<Vector3> felt(int width, int height, int frames,
                            const std::function<Frame(double seconds)> &at,
                            const LawSettings &law = {}) {
    test::VideoHarness harness("roitracker ! velocityavg");
    harness.set_format(GST_VIDEO_FORMAT_GRAY8, width, height);
    HapticLoop loop;
    loop.set_settings({.law_settings = law});
    loop.prepare({.device = device_.get()});
    loop.unhold(haptic::kHoldClosed | haptic::kHoldPaused);
    std::vector<Vector3> forces;
    std::int64_t now = 1000 * kMs;
    for (int i = 0; i < frames; ++i) {
      const BufferPtr buffer =
          harness.pass(at(static_cast<double>(i) / kRate), i * GST_SECOND / kRate);
      submit(loop, buffer.get(), now);
      for (int tick = 0; tick < kTicks; ++tick) {
        now += kMs;
        loop.tick(now, now);
        forces.push_back(loop.wrench().force);
      }
    }
    return forces;
  }

  std::vector<Vector3> felt_motion(int width, int height, Shift velocity,
                                   const LawSettings &law = {}) {
    return felt(
        width, height, 2 * kRate,
        [&](double seconds) {
          return texture_.frame(width, height, {velocity.x * seconds, velocity.y * seconds});
        },
        law);
  }

  /// Equation 5 for a velocity in px/s of a frame 352 px wide, y down.
  static Vector3 equation5(Shift velocity, const LawSettings &law) {
    const double speed = std::hypot(velocity.x, velocity.y);
    const double force = law.max_force * 2 / std::numbers::pi * std::atan(law.alpha * speed);
    return {force * velocity.x / speed, -force * velocity.y / speed, 0};
  }

  /// Half a second at least has the force, within 2 % of the maximum, and no tick a larger one or
  /// one in another direction: before, the force fades in.
  static void expect_force(const std::vector<Vector3> &forces, const Vector3 &wanted,
                           double most = 1) {
    const double near = 0.02 * most; // N
    const Vector3 direction = wanted.normalized();
    int right = 0;
    for (const Vector3 &force : forces) {
      const double along = force.dot(direction);
      EXPECT_GE(along, -near);
      EXPECT_LE(along, wanted.norm() + near);
      EXPECT_LE((force - along * direction).norm(), near);
      right += along >= wanted.norm() - near;
    }
    EXPECT_GE(right, 500) << "of " << forces.size() << " ms";
  }

private:
  static void submit(HapticLoop &loop, GstBuffer *buffer, std::int64_t now) {
    GstMapInfo map;
    ASSERT_TRUE(gst_buffer_map(buffer, &map, GST_MAP_READ));
    const auto sample = haptic::unpack_motion_sample({map.data, map.size});
    gst_buffer_unmap(buffer, &map);
    ASSERT_TRUE(sample);
    if (GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP))
      loop.submit_gap(*sample, now);
    else
      loop.submit(*sample, now);
  }

  test::Texture texture_{7};
  std::unique_ptr<spidar::Device> device_;
};

TEST_F(UniformMotion, GivesTheForceOfEquation5InItsDirection) {
  for (const Shift velocity : {Shift{0, -20}, {0, -100}, {0, -400}, {100, 0}, {60, 80}}) {
    SCOPED_TRACE(testing::Message() << velocity.x << ", " << velocity.y << " px/s");
    expect_force(felt_motion(352, 288, velocity), equation5(velocity, {}));
  }
}

TEST_F(UniformMotion, HasAForceThatTheOptionsChange) {
  const LawSettings law{.max_force = 2, .alpha = 0.02};
  expect_force(felt_motion(352, 288, {0, -100}, law), equation5({0, -100}, law), 2);
}

TEST_F(UniformMotion, ThatLooksTheSameInALargerFrameIsTheSameForce) {
  expect_force(felt_motion(1280, 720, {0, -100.0 * 1280 / 352}), {0, 0.5, 0});
}

TEST_F(UniformMotion, FramesWithoutAMotionToMeasureAreHardlyFelt) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> grey(0, 255);
  const auto snow = [&](double) {
    Frame frame(352, 288);
    for (std::uint8_t &pixel : frame.pixels)
      pixel = static_cast<std::uint8_t>(grey(random));
    return frame;
  };
  const auto black = [](double) { return Frame(352, 288, 16); };
  for (const Vector3 &force : felt(352, 288, 2 * kRate, snow))
    EXPECT_LE(force.norm(), 0.1);
  for (const Vector3 &force : felt(352, 288, 2 * kRate, black))
    EXPECT_LE(force.norm(), 0.1);
}

} // namespace uniform_motion_test
