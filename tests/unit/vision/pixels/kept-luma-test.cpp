// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pixels/kept-luma.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace kept_luma_test {

using haptic::KeptLuma;
using haptic::LumaView;
using haptic::Rectangle;

constexpr int kWidth = 400;
constexpr int kHeight = 300;

// A frame whose luma has to be converted. Counts the pixels that were.
class Source final : public haptic::LumaSource {
public:
  explicit Source(int number) : number_(number) {}

  LumaView plane(const Rectangle &) const override { return {}; }
  void convert(const Rectangle &area, std::uint8_t *to, std::ptrdiff_t stride) const override {
    EXPECT_GE(area.x, 0);
    EXPECT_GE(area.y, 0);
    EXPECT_LE(area.x + area.width, kWidth);
    EXPECT_LE(area.y + area.height, kHeight);
    for (int y = 0; y < area.height; ++y)
      for (int x = 0; x < area.width; ++x)
        to[y * stride + x] = value_at(area.x + x, area.y + y);
    converted += area.width * area.height;
  }

  void expect_shows(const LumaView &view, const Rectangle &area) const {
    ASSERT_EQ(view.width, area.width);
    ASSERT_EQ(view.height, area.height);
    for (int y = 0; y < area.height; ++y)
      for (int x = 0; x < area.width; ++x)
        ASSERT_EQ(view.pixels[y * view.stride + x], value_at(area.x + x, area.y + y))
            << x << ' ' << y << " of " << area.width << 'x' << area.height << '+' << area.x << '+'
            << area.y;
  }

  mutable int converted = 0;

private:
  std::uint8_t value_at(int x, int y) const {
    return static_cast<std::uint8_t>(7 * x + 31 * y + 101 * number_);
  }

  int number_;
};

TEST(KeptLuma, ConvertsAnAreaOnce) {
  const Source frame(1);
  KeptLuma luma;
  const Rectangle area{50, 60, 90, 70};
  frame.expect_shows(luma.read(frame, area), area);
  frame.expect_shows(luma.read(frame, area), area);
  EXPECT_EQ(frame.converted, 90 * 70);
}

TEST(KeptLuma, ConvertsOnlyThePartThatIsNew) {
  const Source frame(1);
  for (const auto &[dx, dy] : {std::pair{5, 0}, {-5, 0}, {0, 9}, {0, -9}, {4, -7}, {-32, 32}}) {
    KeptLuma luma;
    luma.read(frame, {100, 100, 90, 70});
    const int before = frame.converted;
    const Rectangle moved{100 + dx, 100 + dy, 90, 70};
    frame.expect_shows(luma.read(frame, moved), moved);
    EXPECT_EQ(frame.converted - before, 90 * 70 - (90 - std::abs(dx)) * (70 - std::abs(dy)));
  }
}

TEST(KeptLuma, APlaneOfItsOwnIsNeitherConvertedNorCopied) {
  class Plane final : public haptic::LumaSource {
  public:
    LumaView plane(const Rectangle &area) const override {
      return {&pixel, area.width, area.height, 0};
    }
    void convert(const Rectangle &, std::uint8_t *, std::ptrdiff_t) const override {
      ADD_FAILURE() << "there is nothing to convert";
    }
    std::uint8_t pixel = 9;
  };
  const Plane frame;
  KeptLuma luma;
  EXPECT_EQ(luma.read(frame, {1, 2, 3, 4}).pixels, &frame.pixel);
}

// Areas of any size, near and far, at the borders too, and another frame now and then.
TEST(KeptLuma, ShowsTheFrameWhateverWasReadBefore) {
  std::mt19937 random(5);
  const auto between = [&](int least, int most) {
    return std::uniform_int_distribution(least, most)(random);
  };
  KeptLuma luma;
  Rectangle area{100, 100, 60, 60};
  Source frame(0);
  for (int i = 0; i < 3000; ++i) {
    if (i % 5 == 4) {
      luma.forget();
      frame = Source(i);
    }
    const bool jumps = i % 11 == 0;
    area.width = jumps ? between(1, 120) : std::clamp(area.width + between(-6, 6), 1, 120);
    area.height = jumps ? between(1, 120) : std::clamp(area.height + between(-6, 6), 1, 120);
    area.x =
        std::clamp(jumps ? between(0, kWidth) : area.x + between(-40, 40), 0, kWidth - area.width);
    area.y = std::clamp(jumps ? between(0, kHeight) : area.y + between(-40, 40), 0,
                        kHeight - area.height);
    frame.expect_shows(luma.read(frame, area), area);
    if (HasFatalFailure())
      return;
  }
}

} // namespace kept_luma_test
