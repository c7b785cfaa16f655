// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patches/pixel-votes.hpp"

#include "field-frames.hpp"
#include "instruction-sets.hpp"
#include "plane-pairs.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <new>
#include <random>
#include <vector>

namespace pixel_votes_test {

using haptic::Area;
using haptic::Displacement;
using haptic::Patch;
using haptic::Plane;
using test::Frame;
using test::Texture;

constexpr int kSide = 64;
constexpr Area kRegion{16, 16, 30, 30};
constexpr float kNoise = 1.5F * 1.5F;

class PixelVotes : public ::testing::Test {
protected:
  // The left texture up to `border`, the right one from there on.
  void show(unsigned seed, int border, test::Shift left, test::Shift right) {
    test::smooth_things(seed, kSide, border, left, right, earlier, later);
  }

  // Patches on a grid over the region that move as their middle does.
  static std::vector<Patch> patches(float border, Displacement left, Displacement right) {
    std::vector<Patch> all;
    for (int row = 0; row < 5; ++row)
      for (int column = 0; column < 4; ++column) {
        const float x = kRegion.x + (static_cast<float>(column) + 0.5F) * kRegion.width / 4;
        const float y = kRegion.y + (static_cast<float>(row) + 0.5F) * kRegion.height / 5;
        const Displacement d = x < border ? left : right;
        all.push_back({x, y, 8, 8, d.x, d.y, 400, 0, 400, 1, 0});
      }
    return all;
  }

  void count(std::vector<Patch> &all) { votes->count(earlier, later, 0, kRegion, kNoise, all); }

  static float share_of(const std::vector<Patch> &all, Displacement d) {
    float sum = 0;
    for (const Patch &patch : all)
      sum += patch.dx == d.x && patch.dy == d.y ? patch.share : 0;
    return sum;
  }

  std::unique_ptr<haptic::PixelVotes> votes = std::make_unique<haptic::PixelVotes>();
  Plane earlier;
  Plane later;
};

constexpr Displacement kLeft{2, 0};
constexpr Displacement kRight{-1, 1};

// The votes of the scene, counted in memory that held NaN.
std::unique_ptr<haptic::PixelVotes> votes_in_dirty_memory() {
  void *const memory = operator new (sizeof(haptic::PixelVotes), std::align_val_t{64});
  std::memset(memory, 0xFF, sizeof(haptic::PixelVotes));
  asm volatile("" ::"r"(memory) : "memory"); // else the compiler may leave the stores out
  return std::unique_ptr<haptic::PixelVotes>(new (memory) haptic::PixelVotes);
}

TEST_F(PixelVotes, DoNotDependOnWhatTheMemoryHeld) {
  for (const int border : {22, 26, 31, 36, 40})
    for (float width = 20; width <= 30; ++width) {
      show(1, border, {2, 0}, {-1, 1});
      const Area region{16, 16, width, 30};
      const auto counted = [&](haptic::PixelVotes &in) {
        auto all = patches(static_cast<float>(border), kLeft, kRight);
        const float unexplained = in.count(earlier, later, 0, region, kNoise, all);
        std::vector<float> numbers{unexplained};
        for (const Patch &patch : all)
          numbers.push_back(patch.share);
        return numbers;
      };
      const auto dirty = votes_in_dirty_memory();
      *votes = {};
      EXPECT_EQ(counted(*dirty), counted(*votes)) << border << ", " << width;
    }
}

TEST_F(PixelVotes, AreTheAreaOfEachMotionWhereverTheBorderIs) {
  for (const int border : {22, 26, 31, 36, 40}) {
    float mean = 0;
    constexpr int kScenes = 10;
    for (unsigned seed = 1; seed <= kScenes; ++seed) {
      show(seed, border, {2, 0}, {-1, 1});
      auto all = patches(static_cast<float>(border), kLeft, kRight);
      count(all);
      EXPECT_NEAR(share_of(all, kLeft) + share_of(all, kRight), 1, 1e-4F);
      mean += share_of(all, kLeft) / kScenes;
    }
    // The plane begins one pixel further in than the frame.
    EXPECT_NEAR(mean, (static_cast<float>(border) - 1 - kRegion.x) / kRegion.width, 0.05F)
        << border;
  }
}

TEST_F(PixelVotes, OfAPatchThatFollowsNothingAreFew) {
  show(3, kSide, {2, 0}, {});
  auto all = patches(kSide, kLeft, kRight);
  all[9].dx = -3;
  count(all);
  EXPECT_LT(all[9].share, 0.01F);
  EXPECT_GT(share_of(all, kLeft), 0.99F);
}

TEST_F(PixelVotes, OfAPatchWithoutTextureAreFew) {
  show(4, kSide, {2, 0}, {});
  auto all = patches(kSide, kLeft, kRight);
  all[9].precision_xx = all[9].precision_yy = 0;
  all[10].precision_yy = 0;
  count(all);
  EXPECT_LT(all[9].share, 0.01F);
  EXPECT_LT(all[10].share, 0.01F);
}

// A reflection: neither motion explains a pixel.
TEST_F(PixelVotes, OfLayersOverOneAnotherAreTheCommonestMotionAlone) {
  const auto mixed = [](double time) {
    Frame frame = Texture(5, 4, 40).frame(kSide, kSide, {2 * time, 0});
    Frame other = Texture(6, 4, 40).frame(kSide, kSide, {-1 * time, 1 * time});
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x)
        frame.at(x, y) = static_cast<std::uint8_t>((frame.at(x, y) + other.at(x, y)) / 2);
    return frame;
  };
  haptic::smooth(test::view_of(mixed(0)), earlier);
  haptic::smooth(test::view_of(mixed(1)), later);
  auto all = patches(38, kLeft, kRight);
  count(all);
  EXPECT_NEAR(share_of(all, kLeft), 1, 1e-4F);
}

TEST_F(PixelVotes, AtTheBorderOfThePlaneReadNothingOutside) {
  show(7, 30, {2, 0}, {-1, 1});
  auto all = patches(30, kLeft, kRight);
  for (Patch &patch : all) {
    patch.x = patch.x < 30 ? 0 : kSide;
    patch.dx *= 20;
  }
  votes->count(earlier, later, 0, {-4, -4, 80, 80}, kNoise, all);
  for (const Patch &patch : all)
    EXPECT_TRUE(patch.share >= 0 && patch.share <= 1);
}

TEST_F(PixelVotes, DependOnNothingOutsideThePlaneWhateverTheShapes) {
  std::mt19937 random(9);
  const auto between = [&](float least, float most) {
    return std::uniform_real_distribution(least, most)(random);
  };
  const Frame whole = Texture(9, 4, 50).frame(100, 100, {});
  const Frame moved = Texture(9, 4, 50).frame(100, 100, {2, -1});
  int counted = 0;
  for (int i = 0; i < 400; ++i) {
    const auto width = static_cast<int>(between(10, 100));
    const auto height = static_cast<int>(between(10, 100));
    haptic::smooth({whole.pixels.data(), width, height, 100}, earlier);
    haptic::smooth({moved.pixels.data(), width, height, 100}, later);
    const auto right = static_cast<float>(width);
    const auto bottom = static_cast<float>(height);
    const float most = i % 3 == 0 ? 50 : 0.5F; // px off the true displacement
    std::vector<Patch> all;
    for (int count = static_cast<int>(between(1, haptic::kMaxPatches)); count > 0; --count)
      all.push_back({between(-9, right + 9), between(-9, bottom + 9), 8, 8,
                     2 + between(-most, most), between(-most, most) - 1, between(0, 400), 0,
                     between(0, 400), 1, 0});
    const Area region{between(-8, right / 2), between(-8, bottom / 2), between(1, 40),
                      between(1, 40)};
    const auto shares = [&](float outside) {
      test::pad(earlier, outside);
      test::pad(later, outside);
      std::vector<Patch> patches = all;
      votes->count(earlier, later, i % 4 / 3, region, kNoise, patches);
      std::vector<float> found;
      for (const Patch &patch : patches) {
        EXPECT_TRUE(patch.share >= 0 && patch.share <= 1.0001F) << patch.share;
        found.push_back(patch.share);
        counted += patch.share > 0;
      }
      return found;
    };
    EXPECT_EQ(shares(128), shares(std::numeric_limits<float>::quiet_NaN())) << i;
  }
  EXPECT_GT(counted, 1000);
}

TEST_F(PixelVotes, AreTheSameOnEveryInstructionSet) {
  show(8, 30, {2, 0}, {-1, 1});
  auto reference = patches(30, kLeft, kRight);
  count(reference);
  test::for_instruction_sets([&](const char *name) {
    auto all = patches(30, kLeft, kRight);
    count(all);
    for (std::size_t i = 0; i < all.size(); ++i)
      EXPECT_NEAR(all[i].share, reference[i].share, 1e-4F) << name;
  });
}

} // namespace pixel_votes_test
