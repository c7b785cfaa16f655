// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracking/repetition.hpp"

#include <gtest/gtest.h>

namespace repetition_test {

using haptic::Repetition;
using haptic::RepetitionJudge;

constexpr auto kAsThere = [] { return true; };
constexpr auto kOtherThere = [] { return false; };

TEST(RepetitionJudge, FilmShownThreeTimesAndTwiceNeverStandsStill) {
  RepetitionJudge judge;
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(judge.judge(false, kAsThere), Repetition::none);
    EXPECT_EQ(judge.judge(true, kAsThere), Repetition::duplicate);
    EXPECT_EQ(judge.judge(true, kAsThere), Repetition::duplicate);
    EXPECT_EQ(judge.judge(false, kAsThere), Repetition::none);
    EXPECT_EQ(judge.judge(true, kAsThere), Repetition::duplicate);
  }
}

TEST(RepetitionJudge, AThirdOneInARowIsStandstill) {
  RepetitionJudge judge;
  judge.judge(false, kAsThere);
  judge.judge(true, kAsThere);
  judge.judge(true, kAsThere);
  EXPECT_EQ(judge.judge(true, kAsThere), Repetition::still);
  EXPECT_EQ(judge.judge(true, kAsThere), Repetition::still);
}

TEST(RepetitionJudge, AFilmThatRepeatsItsFramesMoreOftenGoesOnToDoSo) {
  for (const int repeats : {3, 5, 7}) {
    RepetitionJudge judge;
    judge.judge(false, kAsThere);
    for (int i = 0; i < repeats; ++i)
      judge.judge(true, kAsThere);
    for (int frame = 0; frame < 3; ++frame) {
      EXPECT_EQ(judge.judge(false, kAsThere), Repetition::none);
      for (int i = 0; i < repeats; ++i)
        EXPECT_EQ(judge.judge(true, kAsThere), Repetition::duplicate) << repeats;
    }
    EXPECT_EQ(judge.judge(true, kAsThere), Repetition::still) << repeats;
  }
}

TEST(RepetitionJudge, WhatStoodStillForLongIsNoFilmThatRepeatsItsFrames) {
  RepetitionJudge judge;
  judge.judge(false, kAsThere);
  for (int i = 0; i < 8; ++i)
    judge.judge(true, kAsThere);
  judge.judge(false, kAsThere);
  judge.judge(true, kAsThere);
  judge.judge(true, kAsThere);
  EXPECT_EQ(judge.judge(true, kAsThere), Repetition::still);
}

TEST(RepetitionJudge, AStreamMayBeginWithADuplicate) {
  RepetitionJudge judge;
  EXPECT_EQ(judge.judge(true, kAsThere), Repetition::duplicate);
  EXPECT_EQ(judge.judge(true, kAsThere), Repetition::duplicate);
  EXPECT_EQ(judge.judge(true, kAsThere), Repetition::still);
  judge.forget();
  EXPECT_EQ(judge.judge(true, kAsThere), Repetition::duplicate);
}

TEST(RepetitionJudge, ThePointerThatLeavesAMovingObjectFindsStandstillAtOnce) {
  RepetitionJudge judge;
  judge.judge(false, kAsThere);
  EXPECT_EQ(judge.judge(true, kOtherThere), Repetition::still);
}

} // namespace repetition_test
