// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scenes/pairs.hpp"

#include "results/report.hpp"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <unistd.h>

namespace {

using namespace lab;
namespace fs = std::filesystem;

class Pairs : public ::testing::Test {
protected:
  Pairs() : folder(fs::path(::testing::TempDir()) / ("pairs-" + std::to_string(getpid()))) {
    fs::create_directories(folder);
  }
  ~Pairs() override { fs::remove_all(folder); }

  void write_frame(const fs::path &name, int width = 4, int height = 3) const {
    fs::create_directories((folder / name).parent_path());
    ASSERT_TRUE(cv::imwrite((folder / name).string(), cv::Mat1b(height, width, std::uint8_t{9})));
  }

  void write_flo(int width, int height, std::size_t values) const {
    std::ofstream file(folder / "leaf_gt.flo", std::ios::binary);
    const float tag = 202021.25F;
    file.write(reinterpret_cast<const char *>(&tag), sizeof tag);
    for (const std::int32_t number : {width, height})
      file.write(reinterpret_cast<const char *>(&number), sizeof number);
    for (std::size_t i = 0; i < values; ++i) {
      const float value = i == 2 ? 1.7e9F : static_cast<float>(i) / 2; // 2: not known
      file.write(reinterpret_cast<const char *>(&value), sizeof value);
    }
  }

  std::string complaint() const {
    try {
      read_pairs(folder);
    } catch (const std::runtime_error &error) {
      return error.what();
    }
    return "none";
  }

  fs::path folder;
};

TEST_F(Pairs, AreReadInTheLayoutOfMiddlebury) {
  write_frame("leaf_10.png");
  write_frame("leaf_11.png");
  write_flo(4, 3, 24);
  const auto pairs = read_pairs(folder);
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].name, "leaf");
  EXPECT_EQ(pairs[0].flow(0, 0), cv::Vec2f(0, 0.5F));
  EXPECT_TRUE(std::isnan(pairs[0].flow(0, 1)[0]));
  EXPECT_EQ(pairs[0].flow(2, 3), cv::Vec2f(11, 11.5F));
}

TEST_F(Pairs, AreReadInTheLayoutOfKitti) {
  write_frame("image_2/000007_10.png");
  write_frame("image_2/000007_11.png");
  cv::Mat stored(3, 4, CV_16UC3, cv::Scalar(0, 0, 0));
  stored.at<cv::Vec3w>(1, 2) = {1, 32768 - 128, 32768 + 96}; // blue valid, green v, red u
  fs::create_directories(folder / "flow_occ");
  ASSERT_TRUE(cv::imwrite((folder / "flow_occ/000007_10.png").string(), stored));
  const auto pairs = read_pairs(folder);
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].flow(1, 2), cv::Vec2f(1.5F, -2));
  EXPECT_TRUE(std::isnan(pairs[0].flow(0, 0)[0]));
}

TEST_F(Pairs, ThatAreNotWholeAreNamed) {
  EXPECT_NE(complaint().find("no pair of frames"), std::string::npos);
  write_flo(4, 3, 24);
  EXPECT_NE(complaint().find("two frames leaf*.png"), std::string::npos);
  write_frame("leaf_10.png");
  write_frame("leaf_11.png", 5);
  EXPECT_NE(complaint().find("not of one size"), std::string::npos);
  write_flo(30000, 30000, 24);
  EXPECT_NE(complaint().find("not as long as"), std::string::npos);
  write_flo(0, 3, 0);
  EXPECT_NE(complaint().find("not a .flo file"), std::string::npos);
}

TEST(Report, NamesThePeersThatBeatTheDefaultInBoth) {
  const auto row = [](const char *method, bool is_peer, double time, double error) {
    return SweepRow{.stratum = "some",
                    .method = method,
                    .is_peer = is_peer,
                    .is_default = !is_peer,
                    .error = error,
                    .time = time};
  };
  std::vector<SweepRow> sweep{row("fast", false, 10, 0.1), row("slow", true, 20, 0.01),
                              row("rough", true, 5, 0.2)};
  EXPECT_TRUE(dominating_peers(sweep).empty());
  sweep.push_back(row("better", true, 9, 0.1));
  const auto found = dominating_peers(sweep);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].method, "better");
}

} // namespace
