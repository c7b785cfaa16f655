// SPDX-License-Identifier: LGPL-2.1-or-later
#include "network/one-sender.hpp"

#include <gtest/gtest.h>

namespace one_sender_test {

using haptic::kSenderSilence;
using haptic::OneSender;
using Verdict = OneSender::Verdict;

TEST(OneSender, TheFirstSenderIsReceivedAndASecondReportedOnce) {
  OneSender senders;
  EXPECT_EQ(senders.packet(1, 100), Verdict::chosen);
  EXPECT_EQ(senders.packet(1, 110), Verdict::pass);
  EXPECT_EQ(senders.packet(2, 120), Verdict::drop); // the first may have ended
  EXPECT_EQ(senders.packet(1, 130), Verdict::pass);
  EXPECT_EQ(senders.packet(2, 140), Verdict::intruder);
  EXPECT_EQ(senders.packet(1, 150), Verdict::pass);
  EXPECT_EQ(senders.packet(2, 160), Verdict::drop);
}

TEST(OneSender, ARestartedSenderIsReceivedAfterASilenceWithoutAReport) {
  OneSender senders;
  senders.packet(1, 0);
  EXPECT_EQ(senders.packet(2, kSenderSilence / 2), Verdict::drop);
  EXPECT_EQ(senders.packet(2, kSenderSilence - 1), Verdict::drop);
  EXPECT_EQ(senders.packet(2, kSenderSilence), Verdict::chosen);
  EXPECT_EQ(senders.packet(2, kSenderSilence + 1), Verdict::pass);
  EXPECT_EQ(senders.packet(1, kSenderSilence + 2), Verdict::drop);
}

TEST(OneSender, AnotherThreadWithATimeBeforeTheLastIsNotChosen) {
  OneSender senders;
  senders.packet(1, 100);
  EXPECT_EQ(senders.packet(2, 99), Verdict::drop);
  EXPECT_EQ(senders.packet(1, 110), Verdict::pass);
}

TEST(OneSender, ASenderThatLeavesMakesRoomAtOnce) {
  OneSender senders;
  senders.packet(1, 0);
  senders.packet(2, 1);
  senders.leave(2);
  EXPECT_EQ(senders.packet(1, 2), Verdict::pass);
  senders.leave(1);
  EXPECT_EQ(senders.packet(3, 3), Verdict::chosen);
}

} // namespace one_sender_test
