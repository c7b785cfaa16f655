// SPDX-License-Identifier: LGPL-2.1-or-later
// On videos the field agrees with the tracker of a region at the same place. FIELD_CLIPS names
// their folder.
#include "field-agreement.hpp"
#include "scenes/pairs.hpp"

#include <cstdlib>
#include <gtest/gtest.h>
#include <map>

namespace {

haptic::LumaView view(const cv::Mat &frame) {
  return {frame.data, frame.cols, frame.rows, static_cast<std::ptrdiff_t>(frame.step)};
}

TEST(FieldOnClips, AgreesWithTheTrackerOfARegionAtTheSamePlace) {
  constexpr int kRuns = 6;
  constexpr int kLength = 4; // the first frames teach the field the clip's noise
  const char *folder = std::getenv("FIELD_CLIPS");
  if (!folder || !std::filesystem::is_directory(folder))
    GTEST_SKIP() << "there are no clips in '" << (folder ? folder : "")
                 << "'; FIELD_CLIPS names a folder with videos";
  std::map<std::string, std::vector<double>> differences;
  std::map<std::string, std::size_t> cells;
  for (const lab::Clip &clip : lab::read_clips(folder, kRuns, kLength)) {
    const cv::Mat &before = clip.frames[kLength - 2];
    const cv::Mat &after = clip.frames[kLength - 1];
    test::Field field(after.cols, after.rows);
    for (const cv::Mat &frame : clip.frames)
      field.follow(view(frame));
    const auto some = test::differences_to_regions(field, view(before), view(after));
    auto &all = differences[clip.name];
    all.insert(all.end(), some.begin(), some.end());
    cells[clip.name] += field.cells.size();
  }
  for (auto &[name, all] : differences) {
    std::ranges::sort(all);
    ASSERT_GT(all.size(), cells[name] / 3) << name;
    EXPECT_LE(all[all.size() / 2], 0.1) << name;
    EXPECT_LE(all[all.size() * 95 / 100], 0.5) << name;
    std::printf("%s: both are sure of %.0f %% of the cells; median %.3f, p95 %.3f px per frame\n",
                name.c_str(),
                100.0 * static_cast<double>(all.size()) / static_cast<double>(cells[name]),
                all[all.size() / 2], all[all.size() * 95 / 100]);
  }
}

} // namespace
