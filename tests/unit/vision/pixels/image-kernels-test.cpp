// SPDX-License-Identifier: LGPL-2.1-or-later
// Each instruction set against plain loops written from the formulas. The sums are exact in
// integers, so that all results must be equal.
#include "instruction-sets.hpp"
#include "pixels/image-kernels.hpp"

#include <gtest/gtest.h>
#include <random>

namespace image_kernels_test {

using haptic::LumaView;

// Random pixels in rows that are longer than the view.
struct Image {
  int width;
  int height;
  int stride;
  std::vector<std::uint8_t> pixels;

  Image(int w, int h, unsigned seed, unsigned levels = 256) : width(w), height(h), stride(w + 5) {
    std::mt19937 random(seed);
    pixels.resize(static_cast<std::size_t>(stride * height));
    for (auto &pixel : pixels)
      pixel = static_cast<std::uint8_t>(random() % levels);
  }
  LumaView view() const { return {pixels.data(), width, height, stride}; }
  int at(int x, int y) const { return pixels[static_cast<std::size_t>(y * stride + x)]; }
};

// Below, at and above the width of every vector, and no multiple of it.
constexpr int kWidths[] = {10, 11, 17, 18, 31, 34, 35, 66, 70, 131, 140};

TEST(ImageKernels, PairsAreAveragedWithRounding) {
  const auto average = [](int a, int b) { return (a + b + 1) / 2; };
  test::for_instruction_sets([&](const char *name) {
    for (const int width : kWidths) {
      const Image fine(width, 13, 1);
      haptic::ByteImage coarse;
      haptic::average_pairs(fine.view(), coarse);
      ASSERT_EQ(coarse.width, width / 2);
      ASSERT_EQ(coarse.height, 6);
      for (int y = 0; y < coarse.height; ++y)
        for (int x = 0; x < coarse.width; ++x)
          ASSERT_EQ(coarse.pixels[static_cast<std::size_t>(y * coarse.width + x)],
                    average(average(fine.at(2 * x, 2 * y), fine.at(2 * x + 1, 2 * y)),
                            average(fine.at(2 * x, 2 * y + 1), fine.at(2 * x + 1, 2 * y + 1))))
              << name << ", width " << width << ", " << x << ' ' << y;
    }
  });
}

TEST(ImageKernels, SmoothingIsTheBinomialKernel) {
  constexpr int kWeights[] = {1, 2, 1};
  test::for_instruction_sets([&](const char *name) {
    for (const int width : kWidths) {
      const Image image(width, 12, 2);
      haptic::Plane plane;
      haptic::smooth(image.view(), plane);
      ASSERT_EQ(plane.width(), width - 2);
      ASSERT_EQ(plane.height(), 10);
      for (int y = 0; y < plane.height(); ++y)
        for (int x = 0; x < plane.width(); ++x) {
          int sum = 0;
          for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i)
              sum += kWeights[i] * kWeights[j] * image.at(x + i, y + j);
          ASSERT_EQ(plane.row(y)[x], static_cast<float>(sum) / 16)
              << name << ", width " << width << ", " << x << ' ' << y;
        }
    }
  });
}

TEST(ImageKernels, HalvingAveragesFourPixels) {
  test::for_instruction_sets([&](const char *name) {
    for (const int width : kWidths) {
      haptic::Plane fine;
      haptic::Plane coarse;
      haptic::smooth(Image(width, 15, 3).view(), fine);
      haptic::halve(fine, coarse);
      ASSERT_EQ(coarse.width(), fine.width() / 2);
      ASSERT_EQ(coarse.height(), fine.height() / 2);
      for (int y = 0; y < coarse.height(); ++y)
        for (int x = 0; x < coarse.width(); ++x) {
          const float *top = fine.row(2 * y) + 2 * x;
          const float *bottom = fine.row(2 * y + 1) + 2 * x;
          ASSERT_EQ(coarse.row(y)[x], (top[0] + top[1] + bottom[0] + bottom[1]) / 4)
              << name << ", width " << width << ", " << x << ' ' << y;
        }
    }
  });
}

TEST(ImageKernels, ChangeSumsAreThoseOfDifferencesAndGradients) {
  test::for_instruction_sets([&](const char *name) {
    for (const int width : {3, 4, 5, 9, 10, 16, 17, 18, 19, 30, 33, 34, 50}) {
      const Image before(width, 30, 4);
      const Image after(width, 30, 5);
      std::int64_t sum = 0, squares = 0, mx = 0, my = 0, xx = 0, xy = 0, yy = 0;
      for (int y = 1; y + 1 < before.height; ++y)
        for (int x = 1; x + 1 < before.width; ++x) {
          const int difference = after.at(x, y) - before.at(x, y);
          const int gx = before.at(x + 1, y) - before.at(x - 1, y); // twice the gradient
          const int gy = before.at(x, y + 1) - before.at(x, y - 1);
          sum += difference;
          squares += difference * difference;
          mx += gx * difference;
          my += gy * difference;
          xx += gx * gx;
          xy += gx * gy;
          yy += gy * gy;
        }
      const haptic::ChangeSums found = haptic::measure_change(before.view(), after.view());
      const auto where = [&] { return testing::Message() << name << ", width " << width; };
      EXPECT_EQ(found.sum, static_cast<float>(sum)) << where();
      EXPECT_EQ(found.squares, static_cast<float>(squares)) << where();
      EXPECT_EQ(found.moment.x, 0.5F * static_cast<float>(mx)) << where();
      EXPECT_EQ(found.moment.y, 0.5F * static_cast<float>(my)) << where();
      EXPECT_EQ(found.structure.xx, 0.25F * static_cast<float>(xx)) << where();
      EXPECT_EQ(found.structure.xy, 0.25F * static_cast<float>(xy)) << where();
      EXPECT_EQ(found.structure.yy, 0.25F * static_cast<float>(yy)) << where();
    }
  });
}

} // namespace image_kernels_test
