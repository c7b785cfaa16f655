// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field/camera-motion.hpp"

#include "field-frames.hpp"
#include "scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>

namespace camera_motion_test {

using haptic::CameraMotion;
using haptic::FieldCell;
using haptic::MotionModel;

constexpr int kWidth = 960;
constexpr int kHeight = 540;
constexpr double kInterval = 1.0 / 30;

struct Scene {
  haptic::FieldShape shape = haptic::field_shape(kWidth, kHeight, 1, 32);
  std::vector<FieldCell> cells;

  // `velocity` of the place from the centre, px/s
  explicit Scene(const std::function<FieldCell(double, double)> &velocity) {
    for (int row = 0; row < shape.rows; ++row)
      for (int column = 0; column < shape.columns; ++column)
        cells.push_back(velocity(((column + 0.5) / shape.columns - 0.5) * kWidth,
                                 ((row + 0.5) / shape.rows - 0.5) * kHeight));
  }
  CameraMotion find() const {
    return haptic::find_camera_motion(cells, shape, kWidth, kHeight, kInterval);
  }
  void subtract(const CameraMotion &camera) {
    haptic::subtract(camera, cells, shape, kWidth, kHeight);
  }
};

FieldCell moving(double x, double y) {
  return {static_cast<float>(x), static_cast<float>(y), 0.9F};
}

// Of a cell that moves by itself: 4 of 10 cells.
bool is_leaf(double x, double y) {
  return std::abs(x) < 0.3 * kWidth && std::abs(y) < 0.35 * kHeight;
}

TEST(CameraMotion, FindsTheSmallestModelOfTheBackgroundBehindMovingThings) {
  struct Case {
    MotionModel model;
    double x, y;
    std::array<double, 4> gradient;
  };
  const Case cases[] = {
      {MotionModel::translation, 240, -60, {}},
      {MotionModel::similarity, 10, 20, {0.5, 0, 0, 0.5}}, // zoom
      {MotionModel::similarity, 0, 0, {0, -0.3, 0.3, 0}},  // roll
      {MotionModel::affine, 30, 0, {0.4, 0.2, 0.0, -0.3}},
  };
  for (const Case &c : cases) {
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0, 0.05 / kInterval);
    const auto camera_at = [&](double x, double y) {
      return moving(c.x + c.gradient[0] * x + c.gradient[1] * y,
                    c.y + c.gradient[2] * x + c.gradient[3] * y);
    };
    const Scene scene([&](double x, double y) {
      FieldCell cell = camera_at(x, y);
      cell.velocity_x += static_cast<float>(noise(random) + (is_leaf(x, y) ? 90 * std::sin(x) : 0));
      cell.velocity_y += static_cast<float>(noise(random) + (is_leaf(x, y) ? 90 * std::cos(y) : 0));
      return cell;
    });
    const CameraMotion found = scene.find();
    EXPECT_EQ(found.model, c.model) << haptic::motion_model_name(found.model);
    // At a corner, within a thirtieth of a pixel a frame.
    const double x = kWidth / 2.0;
    const double y = kHeight / 2.0;
    const FieldCell truth = camera_at(x, y);
    EXPECT_NEAR(found.x + found.gradient[0] * x + found.gradient[1] * y, truth.velocity_x, 1);
    EXPECT_NEAR(found.y + found.gradient[2] * x + found.gradient[3] * y, truth.velocity_y, 1);
  }
}

// What a camera shows of the film: a window of it, moved and enlarged about its centre.
struct View {
  double x = 0; // px of the film, of the window's centre
  double y = 0;
  double zoom = 1;

  test::Frame of(const test::Frame &film, int width, int height) const {
    test::Frame seen(width, height);
    for (int j = 0; j < height; ++j)
      for (int i = 0; i < width; ++i)
        seen.at(i, j) = at(film, x + (i + 0.5 - width / 2.0) / zoom - 0.5,
                           y + (j + 0.5 - height / 2.0) / zoom - 0.5);
    return seen;
  }

private:
  static std::uint8_t at(const test::Frame &film, double x, double y) {
    const int left = static_cast<int>(std::floor(x));
    const int top = static_cast<int>(std::floor(y));
    const double right = x - left;
    const double below = y - top;
    const auto pixel = [&](int column, int row) {
      return static_cast<double>(film.pixels[static_cast<std::size_t>(row) * film.width + column]);
    };
    return static_cast<std::uint8_t>(std::lround(
        (1 - below) * ((1 - right) * pixel(left, top) + right * pixel(left + 1, top)) +
        below * ((1 - right) * pixel(left, top + 1) + right * pixel(left + 1, top + 1))));
  }
};

// The film of the demonstration, its luma alone.
class Film {
public:
  test::Frame draw(double time) {
    test::Frame luma(kWide, kHigh);
    std::vector<std::uint8_t> planes(luma.pixels.size() * 3 / 2);
    scene_.draw(canvas_, time, kFrame);
    canvas_.write_i420(planes);
    std::copy_n(planes.begin(), luma.pixels.size(), luma.pixels.begin());
    return luma;
  }
  static constexpr double kFrame = 1.0 / 60; // s

private:
  static constexpr int kWide = 960;
  static constexpr int kHigh = 540;
  film::Scene scene_{kWide, kHigh, 1};
  film::Canvas canvas_{kWide, kHigh};
};

// Two cameras show one place of the film last: one of them moved there, the other one stood there.
struct TwoCameras {
  static constexpr int kWide = 800;
  static constexpr int kHigh = 450;
  test::Field moved{kWide, kHigh};
  test::Field still{kWide, kHigh};
  CameraMotion camera;
  std::vector<FieldCell> removed;

  TwoCameras(Film &film, double start, const View &step) {
    constexpr int kFrames = 4;
    View view{480 - 1.5 * step.x, 270 - 1.5 * step.y, 1.05};
    const View last{view.x + (kFrames - 1) * step.x, view.y + (kFrames - 1) * step.y,
                    view.zoom * std::pow(step.zoom, kFrames - 1)};
    for (int i = 0; i < kFrames; ++i) {
      const test::Frame drawn = film.draw(start + i * Film::kFrame);
      moved.follow(view.of(drawn, kWide, kHigh));
      still.follow(last.of(drawn, kWide, kHigh));
      view = {view.x + step.x, view.y + step.y, view.zoom * step.zoom};
    }
    camera = haptic::find_camera_motion(moved.cells, moved.shape, kWide, kHigh, 1);
    removed = moved.cells;
    haptic::subtract(camera, removed, moved.shape, kWide, kHigh);
  }

  // px per frame, of the cells that both measured
  double median_difference() const {
    std::vector<double> differences;
    for (std::size_t i = 0; i < removed.size(); ++i)
      if (removed[i].confidence >= 0.5F && still.cells[i].confidence >= 0.5F)
        differences.push_back(std::hypot(removed[i].velocity_x - still.cells[i].velocity_x,
                                         removed[i].velocity_y - still.cells[i].velocity_y));
    std::ranges::nth_element(differences, differences.begin() + differences.size() / 2);
    return differences[differences.size() / 2];
  }
};

TEST(CameraMotion, AFilmInThePanTheZoomAndTheShakeOfACameraMovesAsInAStandingOne) {
  Film film;
  for (const View &step : {View{8, 0, 1}, {-5.3, 4.2, 1}, {1, 0, 1}, {0, 0, 1.02}, {2, 0, 0.99}}) {
    const TwoCameras cameras(film, 5, step);
    EXPECT_NE(cameras.camera.model, MotionModel::none);
    // The median error of a field in this film is 0.1 px.
    EXPECT_LE(cameras.median_difference(), 0.1) << step.x << ", " << step.y << ", " << step.zoom;
  }
}

// A wall without texture in a room with it: only the frame tells how it moves.
TEST(CameraMotion, InAZoomAFlatWallMovesWithTheFrame) {
  constexpr double kZoom = 1.02; // each frame
  constexpr int kFrames = 12;
  test::Frame room = test::Texture(3).frame(960, 540, {});
  for (int y = 230; y < 290; ++y)
    std::fill_n(room.pixels.begin() + std::ptrdiff_t{y} * room.width + 560, 60, std::uint8_t{200});
  test::Field field(480, 270);
  View view{480, 270, 1.1};
  std::mt19937 random(4);
  for (int i = 0; i < kFrames; ++i) {
    test::Frame seen = view.of(room, field.width, field.height);
    test::add_noise(seen, 1, random);
    field.follow(seen, 1.0 / 60);
    view.zoom *= kZoom;
  }
  view.zoom /= kZoom;
  int cells = 0;
  for (int row = 0; row < field.shape.rows; ++row)
    for (int column = 0; column < field.shape.columns; ++column) {
      // From the centre of the frame to that of a cell, px.
      const double x = (column + 0.5) * field.width / field.shape.columns - field.width / 2.0;
      const double y = (row + 0.5) * field.height / field.shape.rows - field.height / 2.0;
      constexpr double kCell = 8; // px
      if (view.x + (x - kCell) / view.zoom < 560 || view.x + (x + kCell) / view.zoom > 620 ||
          view.y + (y - kCell) / view.zoom < 230 || view.y + (y + kCell) / view.zoom > 290)
        continue;
      const haptic::FieldCell &cell = field.at(row, column);
      if (!(cell.confidence > 0))
        continue;
      ++cells;
      EXPECT_NEAR(cell.velocity_x, (1 - 1 / kZoom) * x, 0.3) << column << ", " << row;
      EXPECT_NEAR(cell.velocity_y, (1 - 1 / kZoom) * y, 0.3) << column << ", " << row;
    }
  EXPECT_GE(cells, 8);
}

TEST(CameraMotion, NothingIsSubtractedWhileTheCameraStands) {
  Film film;
  const TwoCameras cameras(film, 5, {});
  EXPECT_EQ(cameras.camera.model, MotionModel::still);
  EXPECT_EQ(cameras.removed, cameras.moved.cells);
}

TEST(CameraMotion, WindEverywhereHasNoBackground) {
  Film film;
  constexpr View kCrown{400, 200, 1};
  for (const double start : {1.0, 8.0, 15.0}) {
    test::Field field(360, 240);
    for (int i = 0; i < 3; ++i)
      field.follow(kCrown.of(film.draw(start + i * Film::kFrame), field.width, field.height));
    const CameraMotion camera =
        haptic::find_camera_motion(field.cells, field.shape, field.width, field.height, 1);
    EXPECT_EQ(camera.model, MotionModel::none);
  }
}

TEST(CameraMotion, WhatMovesInOneHalfOfTheFrameIsNoBackground) {
  std::mt19937 random(3);
  std::normal_distribution<double> wind(0, 60);
  const Scene scene([&](double x, double) {
    return x < 0 ? moving(100, 0) : moving(wind(random), wind(random));
  });
  EXPECT_EQ(scene.find().model, MotionModel::none);
}

TEST(CameraMotion, AFewCellsSayNothingAboutTheCamera) {
  int count = 0;
  const Scene scene([&](double, double) { return ++count % 40 ? FieldCell{} : moving(100, 0); });
  EXPECT_EQ(scene.find().model, MotionModel::none);
}

// An overlay, or a sky too smooth to move.
TEST(CameraMotion, WhatRestsOnTheScreenStaysAtRest) {
  Scene scene([](double, double y) {
    return y < -0.3 * kHeight ? FieldCell{.confidence = 1} : moving(100, 40);
  });
  const CameraMotion camera = scene.find();
  EXPECT_EQ(camera.model, MotionModel::translation);
  scene.subtract(camera);
  for (const FieldCell &cell : scene.cells)
    EXPECT_NEAR(std::hypot(cell.velocity_x, cell.velocity_y), 0, 0.1);
}

} // namespace camera_motion_test
