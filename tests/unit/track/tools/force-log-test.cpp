// SPDX-License-Identifier: LGPL-2.1-or-later
// Tables of columns from outside: those of hapticsink, and damaged ones.
#include "felt/force-log.hpp"
#include "track-error.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <unistd.h>

namespace force_log_test {

using haptic::ForceLog;

class ForceLogs : public testing::Test {
protected:
  ~ForceLogs() override { std::filesystem::remove(path_); }

  ForceLog read(const std::string &text) {
    std::ofstream(path_, std::ios::binary) << text;
    return haptic::read_force_log(path_);
  }

private:
  std::string path_ = testing::TempDir() + "force-log-" + std::to_string(getpid()) + ".csv";
};

TEST_F(ForceLogs, ColumnsAreFoundByTheirNames) {
  const ForceLog log = read("fy,more,time,fx\r\n0.5,word,1,-0.25\r\n\r\n0,,2.5,1e-3\r\n");
  ASSERT_EQ(log.forces.size(), 2U);
  EXPECT_EQ(log.forces[0].time, 1);
  EXPECT_EQ(log.forces[0].force, (haptic::Force{-0.25F, 0.5F, 0}));
  EXPECT_EQ(log.forces[1].force, (haptic::Force{1e-3F, 0, 0}));
  EXPECT_TRUE(log.places.empty());
}

TEST_F(ForceLogs, TheHandPointsIntoTheFrame) {
  const ForceLog log = read("time,x,y,z,fx,fy\n0,0.0125,0.025,-0.0125,0,0\n1,-1,-1,1,0,0\n");
  ASSERT_EQ(log.places.size(), 2U);
  EXPECT_FLOAT_EQ(log.places[0].x, 0.75F);
  EXPECT_FLOAT_EQ(log.places[0].y, 0);
  EXPECT_FLOAT_EQ(log.places[0].z, -0.5F);
  EXPECT_EQ(log.places[1].x, 0);
  EXPECT_EQ(log.places[1].y, 1);
  EXPECT_EQ(log.places[1].z, 1);
}

TEST_F(ForceLogs, OfOneTimeTheLastRowCounts) {
  const ForceLog log = read("time,x,y,fx,fy\n0,0,0,1,0\n0,0,0,2,0\n0,0,0,3,0\n1,0,0,4,0\n");
  ASSERT_EQ(log.forces.size(), 2U);
  EXPECT_EQ(log.places.size(), 2U);
  EXPECT_EQ(log.forces[0].force.x, 3);
}

TEST_F(ForceLogs, DamagedOnesAreRefusedOrSound) {
  std::string text = "time,x,y,z,fx,fy,fz\n";
  for (int i = 0; i < 20; ++i)
    text += std::to_string(0.001 * i) + ",0.001,-0.002,0.003,0.25,-1e-3,0\n";
  std::mt19937 random(1);
  int refused = 0;
  constexpr int kRuns = 150;
  for (int run = 0; run < kRuns; ++run) {
    std::string damaged = text;
    for (unsigned count = 1 + random() % 4; count > 0; --count)
      damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    if (random() % 4 == 0)
      damaged.resize(random() % damaged.size());
    try {
      const ForceLog log = read(damaged);
      EXPECT_TRUE(
          std::ranges::is_sorted(log.forces, std::ranges::less_equal(), &haptic::TimedForce::time));
      EXPECT_TRUE(std::ranges::all_of(log.forces, [](const haptic::TimedForce &row) {
        return std::isfinite(row.time) && std::isfinite(row.force.x) && std::isfinite(row.force.y);
      }));
    } catch (const haptic::TrackFileError &) {
      ++refused;
    }
  }
  EXPECT_GT(refused, kRuns / 4);
  EXPECT_LT(refused, kRuns);
}

} // namespace force_log_test
