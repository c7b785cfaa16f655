// SPDX-License-Identifier: LGPL-2.1-or-later
// The points that wind-film follows: they are where the pixels say, and move as these do.
#include "program/truth.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <set>

namespace film_points_test {

constexpr int kWidth = 960;
constexpr int kHeight = 540;
constexpr std::uint64_t kSeed = 1;
constexpr double kInterval = 1.0 / 30; // s

using film::Kind;
using film::Point;

class FilmPoints : public testing::Test {
protected:
  FilmPoints() : canvas(kWidth, kHeight) { canvas.follow(chosen.points()); }

  std::vector<film::MaterialPoints::Seen> draw(double time) {
    scene.draw(canvas, time, kInterval);
    return chosen.measure(canvas);
  }

  const film::Scene scene{kWidth, kHeight, kSeed};
  film::MaterialPoints chosen{scene, kWidth, kHeight, kSeed};
  film::Canvas canvas;
};

float distance(const Point &a, const Point &b) {
  return length(a - b);
}

// Where the texel is, px from the centre of the top left pixel, read from the texels of three
// pixels that show the same part.
Point place_of(const Point &texel, const Point &here, const Point &right, const Point &below, int x,
               int y) {
  const Point across = right - here;
  const Point down = below - here;
  const Point to = texel - here;
  const float area = across.x * down.y - across.y * down.x;
  const Point solved{(to.x * down.y - to.y * down.x) / area,
                     (across.x * to.y - across.y * to.x) / area};
  return Point{static_cast<float>(x), static_cast<float>(y)} + solved;
}

TEST_F(FilmPoints, AreOnEveryKindOfThingAndVisibleAtFirst) {
  std::map<Kind, int> count;
  for (const film::MaterialPoint &point : chosen.points())
    ++count[point.thing.kind];
  EXPECT_EQ(count.size(), 5U);
  for (const auto &[kind, of_kind] : count)
    EXPECT_EQ(of_kind, film::MaterialPoints::kOfEachKind) << static_cast<int>(kind);
  EXPECT_TRUE(std::ranges::all_of(draw(0), &film::MaterialPoints::Seen::visible));
}

TEST_F(FilmPoints, AreWhereThePixelsSayThatTheirTexelsAre) {
  constexpr float kPixelsAreExact =
      0.02F; // px; texels are kept in 1/65536, steps add up along a row
  constexpr Point kCentre{0.5F, 0.5F};
  std::map<Kind, int> checked;
  for (const double time : {0.0, 1.0, 3.1, 7.5}) {
    const auto seen = draw(time);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const film::MaterialPoint &point = chosen.points()[i];
      const Point place = seen[i].place - kCentre;
      const auto x = static_cast<int>(std::lround(place.x));
      const auto y = static_cast<int>(std::lround(place.y));
      if (!seen[i].visible || x + 1 >= kWidth || y + 1 >= kHeight)
        continue;
      const film::MaterialPoint &here = canvas.material(x, y);
      const film::MaterialPoint &right = canvas.material(x + 1, y);
      const film::MaterialPoint &below = canvas.material(x, y + 1);
      if (here.thing != point.thing || right.thing != point.thing)
        continue;
      const bool is_row = point.thing.kind == Kind::grass || point.thing.kind == Kind::blade;
      if (!is_row && below.thing != point.thing)
        continue;
      const Point found =
          is_row ? place_of(point.texel, here.texel, right.texel, here.texel + Point{0, 1}, x, y)
                 : place_of(point.texel, here.texel, right.texel, below.texel, x, y);
      EXPECT_LT(distance(found, place), kPixelsAreExact)
          << "point " << i << " of kind " << static_cast<int>(point.thing.kind) << " at " << time;
      ++checked[point.thing.kind];
    }
  }
  for (const Kind kind : {Kind::crown_leaf, Kind::branch, Kind::grass, Kind::blade, Kind::flag})
    EXPECT_GT(checked[kind], 15) << static_cast<int>(kind);
}

TEST_F(FilmPoints, MoveAsThePixelsThatShowThem) {
  constexpr float kTolerance = 0.05F; // px a frame: a pixel's motion is that of its centre
  int moving = 0;
  for (const double time : {1.0, 3.1}) {
    const auto before = draw(time - kInterval);
    const auto now = draw(time);
    for (std::size_t i = 0; i < now.size(); ++i) {
      const auto x = static_cast<int>(now[i].place.x);
      const auto y = static_cast<int>(now[i].place.y);
      if (!now[i].visible || canvas.material(x, y).thing != chosen.points()[i].thing)
        continue;
      const film::Motion &motion = canvas.motion(x, y);
      const Point moved = Point{static_cast<float>(motion.x), static_cast<float>(motion.y)} *
                          (1 / film::kMotionUnits);
      const Point step = now[i].place - before[i].place;
      EXPECT_LT(distance(step, moved), kTolerance + 0.05F * length(moved))
          << "point " << i << " of kind " << static_cast<int>(chosen.points()[i].thing.kind);
      moving += length(moved) > 1;
    }
  }
  EXPECT_GT(moving, 50);
}

TEST_F(FilmPoints, HideAndComeBack) {
  std::set<std::size_t> hidden;
  std::set<std::size_t> back;
  for (double time = 0; time < 3; time += 3 * kInterval) {
    const auto seen = draw(time);
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (!seen[i].visible)
        hidden.insert(i);
      else if (hidden.contains(i))
        back.insert(i);
  }
  EXPECT_GT(back.size(), 10U);
}

} // namespace film_points_test
