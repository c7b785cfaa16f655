// SPDX-License-Identifier: LGPL-2.1-or-later
#include "network/pointer-order.hpp"

#include <gtest/gtest.h>

namespace pointer_order_test {

using haptic::PointerOrder;
using std::chrono::milliseconds;

constexpr PointerOrder::Time kStart{std::chrono::hours(1)};

TEST(PointerOrder, AnOlderPacketDoesNotUndoANewerOne) {
  PointerOrder order;
  EXPECT_TRUE(order.accept(7, kStart));
  EXPECT_FALSE(order.accept(7, kStart + milliseconds(1)));
  EXPECT_FALSE(order.accept(6, kStart + milliseconds(2)));
  EXPECT_TRUE(order.accept(9, kStart + milliseconds(3)));
  EXPECT_FALSE(order.accept(8, kStart + milliseconds(4)));
}

TEST(PointerOrder, NumbersGoRound) {
  PointerOrder order;
  EXPECT_TRUE(order.accept(0xFFFFFFFE, kStart));
  EXPECT_TRUE(order.accept(1, kStart));
  EXPECT_FALSE(order.accept(0xFFFFFFFF, kStart));
}

TEST(PointerOrder, AfterASecondOfSilenceTheSenderMayHaveBeenStartedAnew) {
  PointerOrder order;
  EXPECT_TRUE(order.accept(500, kStart));
  EXPECT_FALSE(order.accept(0, kStart + PointerOrder::kForgotten));
  EXPECT_TRUE(order.accept(0, kStart + PointerOrder::kForgotten + milliseconds(1)));
}

} // namespace pointer_order_test
