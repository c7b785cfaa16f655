// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patches/pixel-motions.hpp"

#include "field-frames.hpp"
#include "instruction-sets.hpp"
#include "plane-pairs.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <random>

namespace pixel_motions_test {

using haptic::Area;
using haptic::Displacement;
using haptic::DominantMotion;
using haptic::Plane;
using test::Frame;
using test::Texture;

constexpr int kSide = 64;
constexpr Area kRegion{16, 16, 30, 30};
constexpr float kNoise = 1.5F * 1.5F;

float distance(Displacement a, Displacement b) {
  return std::sqrt(haptic::norm2(a - b));
}

// A later frame that is the earlier one moved, both of any size, a region and a displacement.
class AnyShapes {
public:
  struct Shape {
    Area region;
    Displacement start;
  };

  Shape next(Plane &earlier, Plane &later) {
    const auto width = static_cast<int>(between(10, 100));
    const auto height = static_cast<int>(between(10, 100));
    haptic::smooth({before_.pixels.data(), width, height, 100}, earlier);
    haptic::smooth({after_.pixels.data(), width, height, 100}, later);
    const float most = ++count_ % 3 == 0 ? 50 : 1;
    return {{between(-8, static_cast<float>(width) / 2),
             between(-8, static_cast<float>(height) / 2), between(1, 90), between(1, 90)},
            {2 + between(-most, most), between(-most, most) - 1}};
  }

private:
  float between(float least, float most) {
    return std::uniform_real_distribution(least, most)(random_);
  }

  std::mt19937 random_{9};
  Frame before_ = Texture(9, 4, 50).frame(100, 100, {});
  Frame after_ = Texture(9, 4, 50).frame(100, 100, {2, -1});
  int count_ = 0;
};

class LayersOverOneAnother : public ::testing::Test {
protected:
  // Two textures add up, the first with this weight. The second is flat but for its edges. The
  // later frame is brighter by `light`.
  void show(unsigned seed, double weight, test::Shift first, test::Shift second, int light = 0) {
    std::mt19937 random(seed);
    const auto frame_at = [&](double time) {
      Frame frame = Texture(seed, 4, 50).frame(kSide, kSide, {first.x * time, first.y * time});
      Frame other =
          Texture(seed + 100, 4, 50).frame(kSide, kSide, {second.x * time, second.y * time});
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
          frame.at(x, y) = static_cast<std::uint8_t>(
              std::min(255.0, weight * frame.at(x, y) +
                                  (1 - weight) * (other.at(x, y) < 128 ? 80 : 180) + light * time));
      test::add_noise(frame, 1.5, random);
      return frame;
    };
    haptic::smooth(test::view_of(frame_at(0)), earlier);
    haptic::smooth(test::view_of(frame_at(1)), later);
  }

  DominantMotion find(Displacement start, const Area &region = kRegion) const {
    return haptic::find_dominant_motion(earlier, later, region, start, kNoise);
  }

  Plane earlier;
  Plane later;
};

TEST_F(LayersOverOneAnother, MoveAsTheStrongerOne) {
  constexpr int kScenes = 20;
  float mean = 0;
  for (unsigned seed = 1; seed <= kScenes; ++seed) {
    show(seed, 0.75, {2, 0.5}, {-2, -1});
    const DominantMotion found = find({1.5F, 0.3F});
    mean += distance(found.displacement, {2, 0.5F}) / kScenes;
    EXPECT_LT(found.share, 0.7F) << seed;
  }
  EXPECT_LT(mean, 0.1F);
}

TEST_F(LayersOverOneAnother, AreNotWhatOneMotionExplains) {
  for (const int light : {0, 20}) {
    show(3, 1, {2, 0.5}, {}, light);
    const DominantMotion found = find({1.5F, 0.3F});
    EXPECT_LT(distance(found.displacement, {2, 0.5F}), 0.02F) << light;
    EXPECT_GT(found.share, 0.95F) << light;
  }
}

TEST_F(LayersOverOneAnother, StayAtTheStartWhereMostOfThemLeaveThePlane) {
  show(4, 0.75, {2, 0}, {-2, 0});
  const DominantMotion found = find({40, 0});
  EXPECT_EQ(found.displacement.x, 40);
  EXPECT_EQ(found.displacement.y, 0);
  EXPECT_EQ(found.share, 1);
}

TEST_F(LayersOverOneAnother, DependOnNothingOutsideThePlaneWhateverTheShapes) {
  AnyShapes shapes;
  int moved = 0;
  for (int i = 0; i < 300; ++i) {
    const auto [region, start] = shapes.next(earlier, later);
    const auto found = [&](float outside) {
      test::pad(earlier, outside);
      test::pad(later, outside);
      return find(start, region);
    };
    const DominantMotion one = found(128);
    const DominantMotion other = found(std::numeric_limits<float>::quiet_NaN());
    EXPECT_EQ(distance(one.displacement, other.displacement), 0) << i;
    EXPECT_EQ(one.share, other.share) << i;
    EXPECT_LE(distance(one.displacement, start), 2.01F) << i;
    moved += one.displacement.x != start.x;
  }
  EXPECT_GT(moved, 50);
}

// With a sanitizer it fails where a row before the first one is read.
TEST_F(LayersOverOneAnother, MayMoveByLessThanAFloatCanSayBesideOne) {
  show(8, 0.75, {0, 0}, {-2, -1});
  constexpr Area kCorner{0, 0, 30, 30};
  EXPECT_LT(distance(find({-1e-9F, -1e-9F}, kCorner).displacement, find({}, kCorner).displacement),
            1e-3F);
}

TEST_F(LayersOverOneAnother, MoveAlikeOnEveryInstructionSet) {
  show(8, 0.75, {2, 0.5}, {-2, -1});
  const DominantMotion reference = find({1.5F, 0.3F});
  test::for_instruction_sets([&](const char *name) {
    const DominantMotion found = find({1.5F, 0.3F});
    EXPECT_LT(distance(found.displacement, reference.displacement), 2e-3F) << name;
    EXPECT_NEAR(found.share, reference.share, 5e-3F) << name;
  });
}

constexpr Displacement kLeft{2, 0};
constexpr Displacement kRight{-1, 1};

class ThingsSideBySide : public ::testing::Test {
protected:
  // The left texture up to `border`, the right one from there on.
  void show(unsigned seed, int border) {
    test::smooth_things(seed, kSide, border, {kLeft.x, kLeft.y}, {kRight.x, kRight.y}, earlier,
                        later);
  }

  haptic::TwoMotions find(Displacement first, Displacement second,
                          const Area &region = kRegion) const {
    return labels->find(earlier, later, region, first, second, kNoise);
  }

  std::unique_ptr<haptic::MotionLabels> labels = std::make_unique<haptic::MotionLabels>();
  Plane earlier;
  Plane later;
};

TEST_F(ThingsSideBySide, CountByTheirArea) {
  for (const int border : {24, 28, 31, 34, 38}) {
    constexpr int kScenes = 10;
    float share = 0;
    float error = 0;
    for (unsigned seed = 1; seed <= kScenes; ++seed) {
      show(seed, border);
      const auto found = find({1.7F, 0.3F}, {-1.3F, 0.7F});
      share += found.share / kScenes;
      error += (distance(found.first, kLeft) + distance(found.second, kRight)) / (2 * kScenes);
      EXPECT_LT(found.unexplained, 0.2F) << border;
      EXPECT_FALSE(labels->follows_second(static_cast<float>(border) - 4, 30)) << border;
      EXPECT_TRUE(labels->follows_second(static_cast<float>(border) + 3, 30)) << border;
    }
    // The plane begins one pixel further in than the frame.
    EXPECT_NEAR(1 - share, (static_cast<float>(border) - 1 - kRegion.x) / kRegion.width, 0.05F)
        << border;
    EXPECT_LT(error, 0.1F) << border;
  }
}

TEST_F(ThingsSideBySide, AreNotExplainedByOtherMotions) {
  show(3, 31);
  EXPECT_GT(find(kLeft, {5, 5}).unexplained, 0.3F);
  EXPECT_GT(find({5, 5}, kRight).unexplained, 0.3F);
}

TEST_F(ThingsSideBySide, DependOnNothingOutsideThePlaneWhateverTheShapes) {
  AnyShapes shapes;
  for (int i = 0; i < 300; ++i) {
    const auto [region, start] = shapes.next(earlier, later);
    const auto found = [&](float outside) {
      test::pad(earlier, outside);
      test::pad(later, outside);
      return find(start, {start.y, start.x}, region);
    };
    const haptic::TwoMotions one = found(128);
    const haptic::TwoMotions other = found(std::numeric_limits<float>::quiet_NaN());
    EXPECT_EQ(distance(one.first, other.first), 0) << i;
    EXPECT_EQ(distance(one.second, other.second), 0) << i;
    EXPECT_EQ(one.share, other.share) << i;
    EXPECT_EQ(one.unexplained, other.unexplained) << i;
    EXPECT_TRUE(one.share >= 0 && one.share <= 1) << i;
    labels->follows_second(-1000, 1000);
  }
}

TEST_F(ThingsSideBySide, CountAlikeOnEveryInstructionSet) {
  show(8, 31);
  const auto reference = find({1.7F, 0.3F}, {-1.3F, 0.7F});
  test::for_instruction_sets([&](const char *name) {
    const auto found = find({1.7F, 0.3F}, {-1.3F, 0.7F});
    EXPECT_NEAR(found.share, reference.share, 2e-3F) << name;
    EXPECT_LT(distance(found.first, reference.first), 2e-3F) << name;
    EXPECT_LT(distance(found.second, reference.second), 2e-3F) << name;
  });
}

} // namespace pixel_motions_test
