// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/foreground-flow.hpp"

#include "layer-scene.hpp"
#include "layers/layer-kernels.hpp"

#include <gtest/gtest.h>
#include <memory>

namespace foreground_flow_test {

using haptic::Displacement;
using test::kCropSide;
using test::kCropSize;
using test::Shift;

class ForegroundFlowTest : public ::testing::Test {
protected:
  // The mean flow, away from the border, where pixels come from outside, after the texture was at
  // these places.
  template <typename PlaceOf>
  Displacement after(int frames, PlaceOf &&place_of, const haptic::FlowPrior &prior = {}) {
    haptic::LayerFrame earlier = test::prepared(texture.frame(kCropSide, kCropSide, place_of(0)));
    for (int i = 1; i < frames; ++i) {
      const haptic::LayerFrame later =
          test::prepared(texture.frame(kCropSide, kCropSide, place_of(i)));
      flow->step(earlier, later, prior, 0, kCropSize);
      earlier = later;
    }
    Displacement sum;
    constexpr int kBorder = 20;
    for (int y = kBorder; y < kCropSide - kBorder; ++y)
      for (int x = kBorder; x < kCropSide - kBorder; ++x)
        sum += {flow->flow().x.at(x / 2, y / 2), flow->flow().y.at(x / 2, y / 2)};
    const auto inside = static_cast<float>((kCropSide - 2 * kBorder) * (kCropSide - 2 * kBorder));
    return 1 / inside * sum;
  }

  test::Texture texture{3, 8};
  std::unique_ptr<haptic::ForegroundFlow> flow = std::make_unique<haptic::ForegroundFlow>();
};

TEST_F(ForegroundFlowTest, FindsADisplacementFromItsFirstPairOn) {
  const Displacement found = after(2,
                                   [](int i) {
                                     return Shift{0.8 * i, -0.5 * i};
                                   },
                                   {.region = {.displacement = {0.7F, -0.45F}, .share = 1}});
  EXPECT_NEAR(found.x, 0.8, 0.03);
  EXPECT_NEAR(found.y, -0.5, 0.03);
}

TEST_F(ForegroundFlowTest, FollowsAMotionThatChangesFromFrameToFrame) {
  const auto place = [](int i) { return Shift{4 * std::sin(0.2 * i), 0.3 * i}; };
  const Displacement found = after(20, place);
  EXPECT_NEAR(found.x, place(19).x - place(18).x, 0.05);
  EXPECT_NEAR(found.y, 0.3, 0.03);
}

TEST_F(ForegroundFlowTest, FollowsALargeMotionThatTheFrameMakes) {
  const Displacement found =
      after(3,
            [](int i) {
              return Shift{9.0 * i, 2.0 * i};
            },
            {.frame = {9.1F, 1.9F}, .region = {.displacement = {9.3F, 1.8F}, .share = 1}});
  EXPECT_NEAR(found.x, 9, 0.1);
  EXPECT_NEAR(found.y, 2, 0.1);
}

// It fed itself along the stripes of a flag, up to 15 px a frame within ten seconds.
TEST(ForegroundFlow, ForgetsWhatAnEdgeDoesNotShow) {
  haptic::TensorMap<haptic::HalfMap> structure;
  haptic::VectorMap<haptic::HalfMap> flow;
  constexpr float kSlopes = 1000; // (grey levels/px)^2, all of them down to the right
  for (haptic::HalfMap *map : {&structure.xx, &structure.xy, &structure.yy})
    map->values.fill(kSlopes / 2);
  flow.x.values.fill(4);
  flow.y.values.fill(0);
  haptic::damp(structure, {}, {}, 30, kCropSize, flow);
  EXPECT_NEAR(flow.x.at(10, 10), 2, 0.1) << "across the edge";
  EXPECT_NEAR(flow.y.at(10, 10), 2, 0.1);
}

TEST_F(ForegroundFlowTest, IsAtRestWhereNothingMoves) {
  const Displacement found = after(5, [](int) { return Shift{}; });
  EXPECT_NEAR(found.x, 0, 1e-6);
  EXPECT_NEAR(found.y, 0, 1e-6);
}

} // namespace foreground_flow_test
