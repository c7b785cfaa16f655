// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hold/followed-things.hpp"
#include "moving-texture.hpp"
#include "plane-source.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

namespace followed_things_test {

using haptic::FieldThing;
using haptic::FollowedThings;
using haptic::HoldState;
using test::Frame;
using test::PlaneSource;
using test::Shift;
using test::Texture;

constexpr int kWidth = 640;
constexpr int kHeight = 360;
constexpr float kSeconds = 1 / 30.F;

Frame textured(Shift shift = {}) {
  return Texture(3).frame(kWidth, kHeight, shift);
}

Frame blank() {
  Frame frame = textured();
  std::ranges::fill(frame.pixels, std::uint8_t{90});
  return frame;
}

// The right half moves.
haptic::MotionField field() {
  haptic::MotionField made;
  made.frame_width = kWidth;
  made.frame_height = kHeight;
  made.columns = 32;
  made.rows = 18;
  made.cells.resize(32 * 18);
  for (std::size_t i = 0; i < made.cells.size(); ++i)
    made.cells[i] = {i % 32 < 16 ? 0.F : 60.F, 0, 1};
  return made;
}

std::vector<FieldThing> things_of(const FollowedThings &followed) {
  std::vector<FieldThing> things;
  followed.write(kWidth, kHeight, things);
  return things;
}

TEST(SomeFollowedThings, AreWhereTheyMovedTo) {
  FollowedThings followed;
  const Frame first = textured();
  followed.take(PlaneSource(first), kWidth, kHeight, 0.5F, 0.5F);
  followed.take(PlaneSource(first), kWidth, kHeight, 0.25F, 0.75F);
  ASSERT_EQ(things_of(followed).size(), 2U);
  Frame frame;
  for (int i = 1; i <= 10; ++i) {
    frame = textured({2.0 * i, -1.0 * i});
    followed.follow(PlaneSource(frame), kSeconds);
  }
  followed.rest(PlaneSource(frame), kSeconds);
  const auto things = things_of(followed);
  ASSERT_EQ(things.size(), 2U);
  EXPECT_NE(things[0].id, things[1].id);
  EXPECT_EQ(things[0].state, HoldState::held);
  EXPECT_NEAR(things[0].x * kWidth, 320 + 20, 0.3);
  EXPECT_NEAR(things[0].y * kHeight, 180 - 10, 0.3);
  EXPECT_NEAR(things[1].x * kWidth, 160 + 20, 0.3);
  EXPECT_GT(things[0].radius, 0);
}

TEST(SomeFollowedThings, AreNotTakenWhereThereIsNothingToHold) {
  FollowedThings followed;
  const Frame frame = blank();
  followed.take(PlaneSource(frame), kWidth, kHeight, 0.5F, 0.5F);
  followed.choose(PlaneSource(frame), field(), 16);
  EXPECT_TRUE(things_of(followed).empty());
}

TEST(SomeFollowedThings, AreChosenWhereTheFrameMovesAndApartFromEachOther) {
  FollowedThings followed;
  const Frame frame = textured();
  followed.choose(PlaneSource(frame), field(), 16);
  const auto things = things_of(followed);
  ASSERT_EQ(things.size(), 16U);
  for (std::size_t i = 0; i < things.size(); ++i) {
    EXPECT_EQ(things[i].state, HoldState::held);
    EXPECT_GT(things[i].x, 0.5F);
    for (std::size_t other = 0; other < i; ++other)
      EXPECT_GE(std::hypot((things[i].x - things[other].x) * kWidth,
                           (things[i].y - things[other].y) * kHeight),
                things[other].radius * kWidth);
  }
}

TEST(SomeFollowedThings, EndWhenTheyAreLostWhileThePictureRests) {
  FollowedThings followed;
  const Frame frame = textured();
  const Frame wall = blank();
  followed.take(PlaneSource(frame), kWidth, kHeight, 0.5F, 0.5F);
  for (int i = 0; i < 10; ++i)
    followed.follow(PlaneSource(wall), kSeconds);
  ASSERT_EQ(things_of(followed).size(), 1U);
  EXPECT_EQ(things_of(followed)[0].state, HoldState::hidden);
  for (int i = 0; i < 120; ++i) { // 4 s
    followed.rest(PlaneSource(wall), kSeconds);
    for (const FieldThing &thing : things_of(followed))
      ASSERT_EQ(thing.state, HoldState::hidden) << i; // no field has one that is lost
  }
  EXPECT_TRUE(things_of(followed).empty());
}

TEST(SomeFollowedThings, ThatArePointedAtAreNoneOfThoseThatAreChosen) {
  FollowedThings followed;
  const Frame frame = textured();
  followed.take(PlaneSource(frame), kWidth, kHeight, 0.25F, 0.25F);
  followed.take(PlaneSource(frame), kWidth, kHeight, 0.25F, 0.75F);
  followed.choose(PlaneSource(frame), field(), 2);
  EXPECT_EQ(things_of(followed).size(), 4U);
  followed.choose(PlaneSource(frame), field(), 2);
  EXPECT_EQ(things_of(followed).size(), 4U);
}

TEST(SomeFollowedThings, EndWhenTheyAreLostAndOthersComeWithOtherNumbers) {
  FollowedThings followed;
  const Frame frame = textured();
  followed.choose(PlaneSource(frame), field(), 4);
  std::set<std::uint16_t> ids;
  for (const FieldThing &thing : things_of(followed))
    ids.insert(thing.id);
  const Frame wall = blank();
  for (int i = 0; i < 120; ++i) // 4 s
    followed.follow(PlaneSource(wall), kSeconds);
  EXPECT_TRUE(things_of(followed).empty());
  followed.choose(PlaneSource(frame), field(), 4);
  ASSERT_EQ(things_of(followed).size(), 4U);
  for (const FieldThing &thing : things_of(followed))
    EXPECT_FALSE(ids.contains(thing.id));
}

TEST(SomeFollowedThings, AreAtMostAsManyAsAFieldHolds) {
  FollowedThings followed;
  const Frame frame = textured();
  for (int i = 0; i < 50; ++i)
    followed.take(PlaneSource(frame), kWidth, kHeight, 0.5F, 0.5F);
  EXPECT_EQ(things_of(followed).size(), haptic::kMostFieldThings);
}

} // namespace followed_things_test
