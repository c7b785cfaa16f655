// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/segmentation.hpp"

#include "layer-scene.hpp"

#include <gtest/gtest.h>
#include <memory>

namespace segmentation_test {

using test::kCropSide;
using test::kCropSize;

TEST(Segmentation, TheShareOfTheBackgroundIsWhatTheLeafDoesNotCover) {
  const test::LayerScene scene;
  const auto frame = test::prepared(scene.draw(kCropSide, kCropSide, {}, {0.3, 0.6}));
  const auto segmentation = std::make_unique<haptic::Segmentation>();
  segmentation->find_luma(frame, frame.flat, kCropSize);
  segmentation->divide(frame, 0, 1, kCropSize);
  double covered = 0;
  double found = 0;
  for (int y = 0; y < kCropSide; ++y)
    for (int x = 0; x < kCropSide; ++x) {
      covered += scene.cover(x, y, {0.3, 0.6});
      found += 1 - static_cast<double>(segmentation->share().at(x, y));
    }
  EXPECT_NEAR(found / covered, 1, 0.05);
  EXPECT_EQ(segmentation->share().at(4, 4), 1);
  EXPECT_EQ(segmentation->share().at(40, 40), 0);
}

TEST(Segmentation, WithoutABackgroundThereIsNoShareOfIt) {
  const test::Texture leaves(3);
  const auto frame = test::prepared(leaves.frame(kCropSide, kCropSide, {}));
  haptic::CellMap none;
  none.values.fill(0);
  const auto segmentation = std::make_unique<haptic::Segmentation>();
  segmentation->find_luma(frame, none, kCropSize);
  segmentation->divide(frame, 0, 1, kCropSize);
  for (int i = 0; i < kCropSide; ++i)
    EXPECT_EQ(segmentation->share().at(i, i), 0);
}

} // namespace segmentation_test
