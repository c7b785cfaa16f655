// SPDX-License-Identifier: LGPL-2.1-or-later
#include "../layers/layer-scene.hpp"
#include "field-frames.hpp"
#include "field/field-tracker.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace field_tracker_test {

using haptic::FieldCell;
using haptic::FieldShape;
using test::Field;
using test::Frame;
using test::Shift;
using test::Texture;

constexpr int kWidth = 640;
constexpr int kHeight = 360;

// Errors of the cells with a confidence of at least 0.5.
struct Errors {
  std::vector<double> sorted; // px
  double answered = 0;        // share of the cells that have a truth

  double percentile(double share) const {
    const double last = static_cast<double>(sorted.size()) - 1;
    return sorted.empty() ? std::numeric_limits<double>::infinity()
                          : sorted[static_cast<std::size_t>(share * last)];
  }
};

// `truth_at` returns the truth at the middle of a cell, or nothing if the cell does not count.
Errors errors(const Field &field, const auto &truth_at) {
  Errors errors;
  int asked = 0;
  for (int row = 0; row < field.shape.rows; ++row)
    for (int column = 0; column < field.shape.columns; ++column) {
      const std::optional<Shift> truth =
          truth_at((column + 0.5) * field.width / field.shape.columns,
                   (row + 0.5) * field.height / field.shape.rows);
      if (!truth)
        continue;
      ++asked;
      const FieldCell &cell = field.at(row, column);
      if (cell.confidence >= 0.5F)
        errors.sorted.push_back(std::hypot(cell.velocity_x - truth->x, cell.velocity_y - truth->y));
    }
  std::ranges::sort(errors.sorted);
  errors.answered = static_cast<double>(errors.sorted.size()) / asked;
  return errors;
}

// Whether the pixels of a cell stay inside the frame when they move so far.
bool stays(const Field &field, double x, double y, Shift moved) {
  const double half_width = field.width / 2.0 / field.shape.columns;
  const double half_height = field.height / 2.0 / field.shape.rows;
  return x + moved.x >= half_width && x + moved.x <= field.width - half_width &&
         y + moved.y >= half_height && y + moved.y <= field.height - half_height;
}

double known_share(const Field &field) {
  return static_cast<double>(std::ranges::count_if(
             field.cells, [](const FieldCell &cell) { return cell.confidence > 0; })) /
         field.shape.cells();
}

TEST(FieldShape, CellsAreAsSquareAsTheyCanBe) {
  const auto shape = [](int width, int height, double aspect, int columns) {
    return haptic::field_shape(width, height, aspect, columns);
  };
  EXPECT_EQ(shape(1920, 1080, 1, 32), (FieldShape{32, 18}));
  EXPECT_EQ(shape(3840, 2160, 1, 32), (FieldShape{32, 18}));
  EXPECT_EQ(shape(352, 288, 1, 32), (FieldShape{32, 26}));
  EXPECT_EQ(shape(720, 576, 64.0 / 45, 32), (FieldShape{32, 18}));
  EXPECT_EQ(shape(1920, 8, 1, 32), (FieldShape{32, 1}));
}

TEST(FieldShape, HasNoMoreCellsThanReadersAcceptAndNoneTooSmallToMeasure) {
  for (const auto &[width, height] :
       {std::pair(1, 1), {16, 16}, {64, 100'000}, {1080, 1920}, {100'000, 8}, {8192, 8192}})
    for (const int columns : {4, 32, 96}) {
      const FieldShape shape = haptic::field_shape(width, height, 1, columns);
      EXPECT_GE(shape.cells(), 1);
      EXPECT_LE(shape.cells(), static_cast<int>(haptic::kMostFieldCells));
      EXPECT_LE(shape.columns, std::max(1, width / 8));
      EXPECT_LE(shape.rows, std::max(1, height / 8));
    }
}

TEST(FieldTracker, OneTranslationIsThatOfEveryCell) {
  for (const double length : {0.3, 1.0, 3.0, 7.0, 12.0})
    for (const double direction : {0.4, 2.9, 4.4}) {
      const Shift truth{length * std::cos(direction), length * std::sin(direction)};
      const Texture texture(static_cast<unsigned>(10 * length + direction));
      std::mt19937 random(1);
      Frame before = texture.frame(kWidth, kHeight, {});
      Frame after = texture.frame(kWidth, kHeight, truth);
      test::add_noise(before, 1.5, random);
      test::add_noise(after, 1.5, random);
      Field field(kWidth, kHeight);
      EXPECT_EQ(field.measure(before, after), 0U);
      const Errors found = errors(field, [&](double x, double y) {
        return stays(field, x, y, truth) ? std::optional(truth) : std::nullopt;
      });
      EXPECT_GT(found.answered, 0.98) << length;
      EXPECT_LT(found.percentile(0.5), 0.05) << length;
      EXPECT_LT(found.percentile(0.95), 0.1) << length;
      EXPECT_LT(found.percentile(0.99), 0.2) << length;
    }
}

TEST(FieldTracker, ReducedFramesAreMeasuredInPixelsOfTheWholeFrame) {
  for (const Shift truth : {Shift{0.5, -0.3}, {5.3, 2.2}, {-23, 11}}) {
    const Texture texture(3, 10);
    const Frame before = texture.frame(1280, 720, {});
    const Frame after = texture.frame(1280, 720, truth);
    Field field(1280, 720);
    field.measure(before, after);
    const Errors found = errors(field, [&](double x, double y) {
      return stays(field, x, y, truth) ? std::optional(truth) : std::nullopt;
    });
    EXPECT_GT(found.answered, 0.98) << truth.x;
    EXPECT_LT(found.percentile(0.5), 0.05) << truth.x;
    EXPECT_LT(found.percentile(0.95), 0.15) << truth.x;
  }
}

TEST(FieldTracker, TwoObjectsMoveEachInItsOwnWay) {
  const Shift left{2.3, -1.1};
  const Shift right{-3.2, 0.8};
  const Texture left_texture(1);
  const Texture right_texture(2);
  const auto frame = [&](double time) {
    Frame both = left_texture.frame(kWidth, kHeight, {time * left.x, time * left.y});
    right_texture.paint(both, {time * right.x, time * right.y}, kWidth / 2);
    return both;
  };
  Field field(kWidth, kHeight);
  field.measure(frame(0), frame(1));
  const double cell = static_cast<double>(kWidth) / field.shape.columns;
  const Errors found = errors(field, [&](double x, double y) -> std::optional<Shift> {
    // In the cells on either side of the border, pixels appear or disappear.
    if (std::abs(x - kWidth / 2.0) < cell || !stays(field, x, y, left) ||
        !stays(field, x, y, right))
      return std::nullopt;
    return x < kWidth / 2.0 ? left : right;
  });
  EXPECT_GT(found.answered, 0.98);
  EXPECT_LT(found.percentile(0.5), 0.05);
  EXPECT_LT(found.percentile(1), 0.5);
}

// Everything right of an oblique line is another thing, and moves with the line.
struct Halves {
  static constexpr int kWidth = 320;
  static constexpr int kHeight = 200;
  static constexpr int kColumns = 16;
  double direction; // of the line's normal, radians
  Shift ground;     // px per frame
  Shift object;
  unsigned seed;

  // px; positive: inside the object.
  double depth(double x, double y, double time) const {
    return (x - kWidth / 2.0 - object.x * time) * std::cos(direction) +
           (y - kHeight / 2.0 - object.y * time) * std::sin(direction);
  }
  Frame frame(double time) const {
    Frame both = Texture(seed).frame(kWidth, kHeight, {ground.x * time, ground.y * time});
    Frame other = Texture(seed + 100).frame(kWidth, kHeight, {object.x * time, object.y * time});
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double covered = std::clamp(depth(x + 0.5, y + 0.5, time) + 0.5, 0.0, 1.0);
        both.at(x, y) = static_cast<std::uint8_t>(
            std::lround((1 - covered) * both.at(x, y) + covered * other.at(x, y)));
      }
    std::mt19937 random(seed + static_cast<unsigned>(1000 * time));
    test::add_noise(both, 1.5, random);
    return both;
  }
  // Mean over the pixels of a cell, or nothing if it shows one thing alone or lies at a border of
  // the frame.
  std::optional<Shift> mean(double middle_x, double middle_y) const {
    constexpr double kHalf = kWidth / 2.0 / kColumns;
    int inside = 0;
    int all = 0;
    for (double y = middle_y - kHalf + 0.5; y < middle_y + kHalf; ++y)
      for (double x = middle_x - kHalf + 0.5; x < middle_x + kHalf; ++x, ++all)
        inside += depth(x, y, 0) > 0;
    const double share = static_cast<double>(inside) / all;
    if (share < 0.05 || share > 0.95 || middle_y < 2 * kHalf || middle_y > kHeight - 2 * kHalf)
      return std::nullopt;
    return Shift{(1 - share) * ground.x + share * object.x,
                 (1 - share) * ground.y + share * object.y};
  }
};

TEST(FieldTracker, CellsOnABorderHaveTheMeanMotionOfTheirPixels) {
  constexpr double kWrong = 0.5; // px
  double sum = 0;
  int cells = 0;
  int sure = 0;
  int wrong_and_sure = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-3, 3);
    const Shift ground{any(random), any(random)};
    const Shift object{any(random), any(random)};
    const Halves halves{0.4 + 0.2 * seed, ground, object, seed};
    Field field(Halves::kWidth, Halves::kHeight, Halves::kColumns);
    field.measure(halves.frame(0), halves.frame(1));
    for (int row = 0; row < field.shape.rows; ++row)
      for (int column = 0; column < field.shape.columns; ++column) {
        const auto truth = halves.mean((column + 0.5) * field.width / field.shape.columns,
                                       (row + 0.5) * field.height / field.shape.rows);
        if (!truth)
          continue;
        const FieldCell &cell = field.at(row, column);
        const double error = std::hypot(cell.velocity_x - truth->x, cell.velocity_y - truth->y);
        sum += error;
        ++cells;
        sure += cell.confidence >= 0.5F;
        wrong_and_sure += cell.confidence >= 0.5F && error > kWrong;
      }
  }
  EXPECT_LT(sum / cells, 0.3);
  EXPECT_GT(sure, 2 * cells / 5);
  EXPECT_LE(wrong_and_sure, cells / 20);
}

// A sky without an edge drifts behind a leaf that sways. Two frames alone do not show its motion.
TEST(FieldTracker, CellsOfALeafAndTheSkyBehindItHaveTheMeanOfBoth) {
  constexpr int kFrames = 90;
  constexpr int kFirst = 30;     // frame, when the field has seen enough
  constexpr double kDrift = 0.1; // px per frame
  test::LayerScene scene;
  scene.place = {160, 90};
  scene.radius = 25;
  Field field(320, 180, 16);
  double error = 0;
  double speed = 0;
  Shift before;
  for (int i = 0; i < kFrames; ++i) {
    const Shift leaf{6 * std::sin(0.12 * i), 2 * std::cos(0.1 * i)};
    field.follow(scene.draw(field.width, field.height, {kDrift * i, 0}, leaf), 1.0 / 60);
    const Shift moved{leaf.x - before.x, leaf.y - before.y};
    before = leaf;
    for (int row = 0; i >= kFirst && row < field.shape.rows; ++row)
      for (int column = 0; column < field.shape.columns; ++column) {
        double share = 0;
        for (int y = 0; y < 20; ++y)
          for (int x = 0; x < 20; ++x)
            share += scene.cover(20 * column + x, 20 * row + y, leaf) / 400;
        if (share < 0.1 || share > 0.9)
          continue;
        const Shift truth{share * moved.x + (1 - share) * kDrift, share * moved.y};
        const FieldCell &cell = field.at(row, column);
        EXPECT_GT(cell.confidence, 0.5F) << i << ' ' << row << ' ' << column;
        error += std::hypot(cell.velocity_x - truth.x, cell.velocity_y - truth.y);
        speed += std::hypot(truth.x, truth.y);
      }
  }
  EXPECT_LT(error, 0.25 * speed);
}

// Of two fields, half a frame apart.
TEST(FieldTracker, InterlacedFramesThatMoveAsOneAreMeasured) {
  constexpr int kFrames = 18;
  constexpr int kFirst = 12; // frame, when the layers would have seen enough
  const Texture texture(5);
  Field field(kWidth, kHeight);
  for (int i = 0; i < kFrames; ++i) {
    Frame woven = texture.frame(kWidth, kHeight, {6.0 * i, 1.0 * i});
    const Frame later = texture.frame(kWidth, kHeight, {6.0 * i + 3, 1.0 * i + 0.5});
    for (std::ptrdiff_t y = 1; y < kHeight; y += 2)
      std::copy_n(later.pixels.begin() + y * kWidth, kWidth, woven.pixels.begin() + y * kWidth);
    field.follow(woven, 1.0 / 30);
    if (i < kFirst)
      continue;
    const Errors found = errors(field, [&](double x, double y) -> std::optional<Shift> {
      const Shift moved{6, 1};
      return stays(field, x, y, moved) ? std::optional(moved) : std::nullopt;
    });
    EXPECT_GT(found.answered, 0.98);
    EXPECT_LT(found.percentile(0.99), 0.1);
  }
}

TEST(FieldTracker, ASmallObjectIsSeenWhereItIs) {
  const Texture ground(1);
  const Texture object(2);
  const auto frame = [&](int time) {
    Frame both = ground.frame(kWidth, kHeight, {});
    const Frame moving = object.frame(60, 60, {});
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 60; ++x)
        both.pixels[static_cast<std::size_t>((y + 160) * kWidth + x + 300 + 6 * time)] =
            moving.pixels[static_cast<std::size_t>(y * 60 + x)];
    return both;
  };
  Field field(kWidth, kHeight);
  field.measure(frame(0), frame(1));
  const FieldCell &inside = field.at(9, 16); // 320..340 x 180..200
  EXPECT_NEAR(inside.velocity_x, 6, 0.1);
  EXPECT_NEAR(inside.velocity_y, 0, 0.1);
  EXPECT_GT(inside.confidence, 0.5F);
  EXPECT_EQ(field.at(2, 3), (FieldCell{.confidence = 1}));
  EXPECT_EQ(field.at(15, 28), (FieldCell{.confidence = 1}));
}

TEST(FieldTracker, RotationAndZoomAreTheMotionOfEachPlace) {
  constexpr double kAngle = 0.02; // rad: 7 px at the corners
  constexpr double kZoom = 1.02;
  const Texture texture(4);
  Field field(kWidth, kHeight);
  const Frame before = texture.frame(kWidth, kHeight, {});
  const auto check = [&](double spin, double growth) {
    const Errors found = errors(field, [&](double x, double y) -> std::optional<Shift> {
      const double rx = x - kWidth / 2.0;
      const double ry = y - kHeight / 2.0;
      const Shift moved{growth * rx - spin * ry, growth * ry + spin * rx};
      return stays(field, x, y, moved) ? std::optional(moved) : std::nullopt;
    });
    EXPECT_GT(found.answered, 0.95);
    EXPECT_LT(found.percentile(0.5), 0.06);
    EXPECT_LT(found.percentile(0.95), 0.15);
  };
  field.measure(before, texture.turned(kWidth, kHeight, kAngle));
  check(kAngle, 0);
  field.measure(before, texture.zoomed(kWidth, kHeight, kZoom));
  check(0, kZoom - 1);
}

TEST(FieldTracker, ABlankWallGivesNoVelocity) {
  std::mt19937 random(1);
  for (const auto &[width, height] : {std::pair(352, 288), {640, 360}, {1280, 720}})
    for (const double noise : {0.7, 1.5, 3.0}) {
      Field field(width, height);
      for (int i = 0; i < 4; ++i) {
        Frame wall(width, height, 120);
        test::add_noise(wall, noise, random);
        field.follow(wall);
        EXPECT_EQ(known_share(field), 0) << width << ", noise " << noise;
      }
    }
}

TEST(FieldTracker, AStillSceneIsExactlyZeroWhateverItsNoise) {
  std::mt19937 random(1);
  const Texture texture(6);
  for (const double noise : {0.0, 1.5, 5.0}) {
    Field field(kWidth, kHeight);
    int moving = 0;
    for (int i = 0; i < 8; ++i) {
      Frame frame = texture.frame(kWidth, kHeight, {});
      test::add_noise(frame, noise, random);
      const std::uint32_t flags = field.follow(frame);
      // The noise is learned from the first frames.
      if (i < 4)
        continue;
      moving += static_cast<int>(std::ranges::count_if(field.cells, [](const FieldCell &cell) {
        return cell.velocity_x != 0 || cell.velocity_y != 0;
      }));
      EXPECT_GT(known_share(field), 0.98) << noise;
      if (noise == 0) {
        EXPECT_EQ(flags, haptic::kStill);
      }
    }
    EXPECT_LE(moving, 0.002 * 4 * field.shape.cells()) << noise;
  }
}

TEST(FieldTracker, MeasuresThroughStrongNoise) {
  std::mt19937 random(1);
  const Shift truth{2.4, -1.7};
  Frame before = Texture(7).frame(kWidth, kHeight, {});
  Frame after = Texture(7).frame(kWidth, kHeight, truth);
  test::add_noise(before, 6, random);
  test::add_noise(after, 6, random);
  Field field(kWidth, kHeight);
  field.measure(before, after);
  const Errors found = errors(field, [&](double x, double y) {
    return stays(field, x, y, truth) ? std::optional(truth) : std::nullopt;
  });
  EXPECT_GT(found.answered, 0.9);
  EXPECT_LT(found.percentile(0.5), 0.1);
  EXPECT_LT(found.percentile(0.95), 0.25);
}

TEST(FieldTracker, ChangedLightIsNoMotion) {
  const Texture texture(8, 5, 25);
  const Frame before = texture.frame(kWidth, kHeight, {});
  Frame after = before;
  for (auto &pixel : after.pixels)
    pixel = static_cast<std::uint8_t>(std::clamp(1.15 * pixel - 5, 0.0, 255.0));
  Field field(kWidth, kHeight);
  field.measure(before, after);
  const Errors found = errors(field, [](double, double) { return std::optional(Shift{}); });
  EXPECT_GT(found.answered, 0.98);
  EXPECT_LT(found.percentile(0.99), 0.05);
}

TEST(FieldTracker, AnotherSceneIsACutWithoutVelocity) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Field field(kWidth, kHeight);
    const Texture first(seed);
    const Texture second(seed + 50);
    EXPECT_EQ(field.measure(first.frame(kWidth, kHeight, {}), second.frame(kWidth, kHeight, {})),
              haptic::kCut);
    EXPECT_EQ(known_share(field), 0);
    EXPECT_EQ(field.follow(second.frame(kWidth, kHeight, {3, 1})), 0U);
    EXPECT_GT(known_share(field), 0.9);
  }
}

// A grating with this period in px along x.
Frame grating(double period, double shift) {
  Frame frame(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      frame.at(x, y) = static_cast<std::uint8_t>(
          std::lround(128 + 60 * std::sin(2 * std::numbers::pi * (x + 0.5 - shift) / period)));
  return frame;
}

TEST(FieldTracker, EdgesOfOneDirectionGiveThePartAcrossThemWithLessConfidence) {
  // Two periods together: where the one repeats, the other does not.
  const auto frame = [](double shift) {
    Frame sum = grating(37, shift);
    const Frame other = grating(23, shift);
    for (std::size_t i = 0; i < sum.pixels.size(); ++i)
      sum.pixels[i] = static_cast<std::uint8_t>((sum.pixels[i] + other.pixels[i]) / 2);
    return sum;
  };
  Field field(kWidth, kHeight);
  field.measure(frame(0), frame(1.6));
  int known = 0;
  for (int row = 0; row < field.shape.rows; ++row)
    for (int column = 1; column + 1 < field.shape.columns; ++column) {
      const FieldCell &cell = field.at(row, column);
      if (!(cell.confidence > 0))
        continue;
      ++known;
      EXPECT_NEAR(cell.velocity_x, 1.6, 0.15);
      EXPECT_NEAR(cell.velocity_y, 0, 0.05);
      EXPECT_LT(cell.confidence, 0.5F);
    }
  EXPECT_GT(known, field.shape.cells() / 2);
}

TEST(FieldTracker, ATextureThatRepeatsIsNotFollowedByAPeriodMore) {
  // In both directions, so that there are no edges; moved by more than half a period.
  const auto frame = [](double shift) {
    Frame sum = grating(9, shift);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        sum.at(x, y) = static_cast<std::uint8_t>(
            (sum.at(x, y) +
             std::lround(128 + 60 * std::sin(2 * std::numbers::pi * (y + 0.5) / 9))) /
            2);
    return sum;
  };
  Field field(kWidth, kHeight);
  field.follow(frame(0));
  // A start that is slow enough is followed.
  for (int i = 1; i <= 5; ++i) {
    field.follow(frame(1.0 * i));
    const Errors found = errors(field, [&](double x, double y) {
      return stays(field, x, y, {1, 0}) ? std::optional(Shift{1, 0}) : std::nullopt;
    });
    EXPECT_GT(found.answered, 0.9);
    EXPECT_LT(found.percentile(0.99), 0.2);
  }
  // A motion that may as well be slower in the other direction is rejected.
  field.measure(frame(0), frame(4));
  EXPECT_LT(errors(field, [](double, double) { return std::optional(Shift{}); }).answered, 0.05);
}

TEST(FieldTracker, FramesOfAnySizeAreMeasuredOrGiveNoVelocity) {
  for (const auto &[width, height] : {std::pair(1, 1),
                                      {3, 300},
                                      {13, 13},
                                      {16, 16},
                                      {17, 33},
                                      {355, 203},
                                      {333, 71},
                                      {2000, 14}}) {
    const Shift truth{1.3, -0.7};
    const Texture texture(9);
    Field field(width, height);
    field.measure(texture.frame(width, height, {}), texture.frame(width, height, truth));
    const Errors found = errors(field, [&](double x, double y) {
      return stays(field, x, y, truth) ? std::optional(truth) : std::nullopt;
    });
    if (std::min(width, height) > 64) {
      EXPECT_GT(found.answered, 0.95) << width << 'x' << height;
    }
    if (!found.sorted.empty()) {
      EXPECT_LT(found.percentile(0.9), 0.2) << width << 'x' << height;
    }
  }
}

TEST(FieldTracker, FollowsAFrameOfFourThousandPixels) {
  // The same frame side by side in both directions, moved by whole pixels.
  constexpr int kTile = 256;
  const Frame tile = Texture(10, 24).frame(kTile, kTile, {});
  const auto frame = [&](int shift) {
    Frame large(3840, 2160);
    for (int y = 0; y < large.height; ++y)
      for (int x = 0; x < large.width; ++x)
        large.at(x, y) = tile.pixels[static_cast<std::size_t>((y + kTile) % kTile * kTile +
                                                              (x + 4 * kTile - shift) % kTile)];
    return large;
  };
  Field field(3840, 2160);
  EXPECT_EQ(field.shape, (FieldShape{32, 18}));
  field.measure(frame(0), frame(30));
  const Errors found = errors(field, [&](double x, double y) {
    return stays(field, x, y, {30, 0}) ? std::optional(Shift{30, 0}) : std::nullopt;
  });
  EXPECT_GT(found.answered, 0.95);
  EXPECT_LT(found.percentile(0.5), 0.1);
  EXPECT_LT(found.percentile(0.95), 0.5);
}

TEST(FieldTracker, AnEqualFrameRepeats) {
  Field field(kWidth, kHeight);
  const Frame frame = Texture(11).frame(kWidth, kHeight, {});
  test::read(field.tracker, view_of(frame));
  EXPECT_FALSE(field.tracker.repeats());
  field.tracker.keep();
  test::read(field.tracker, view_of(frame));
  EXPECT_TRUE(field.tracker.repeats());
  Frame other = frame;
  other.at(kWidth - 1, kHeight - 1) ^= 0x80;
  test::read(field.tracker, view_of(other));
  EXPECT_FALSE(field.tracker.repeats());
}

} // namespace field_tracker_test
