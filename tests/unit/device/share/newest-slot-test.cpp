// SPDX-License-Identifier: LGPL-2.1-or-later
#include "share/newest-slot.hpp"

#include <gtest/gtest.h>
#include <thread>

namespace newest_slot_test {

// Large enough that a torn copy would show.
struct Value {
  std::array<std::uint64_t, 32> words{};
  static Value of(std::uint64_t n) {
    Value v;
    v.words.fill(n);
    return v;
  }
  bool whole() const {
    for (auto w : words)
      if (w != words.front())
        return false;
    return true;
  }
};

TEST(NewestSlot, HoldsItsInitialValueUntilSomethingIsWritten) {
  haptic::NewestSlot<Value> slot;
  EXPECT_FALSE(slot.refresh());
  EXPECT_EQ(slot.value().words[0], 0U);
}

TEST(NewestSlot, TheNewestWins) {
  haptic::NewestSlot<Value> slot;
  for (std::uint64_t n = 1; n <= 5; ++n)
    slot.write(Value::of(n));
  EXPECT_TRUE(slot.refresh());
  EXPECT_EQ(slot.value().words[0], 5U);
  EXPECT_FALSE(slot.refresh());
  EXPECT_EQ(slot.value().words[0], 5U);
}

TEST(NewestSlot, AReaderNeverSeesHalfAValueOrAnOlderOne) {
  constexpr std::uint64_t kWrites = 300'000;
  haptic::NewestSlot<Value> slot;
  std::thread writer([&] {
    for (std::uint64_t n = 1; n <= kWrites; ++n)
      slot.write(Value::of(n));
  });
  std::uint64_t last = 0;
  while (last < kWrites) {
    if (!slot.refresh()) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_TRUE(slot.value().whole());
    ASSERT_GT(slot.value().words[0], last);
    last = slot.value().words[0];
  }
  writer.join();
}

} // namespace newest_slot_test
