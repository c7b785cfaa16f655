// SPDX-License-Identifier: LGPL-2.1-or-later
// Calls of handlers, which the pool's thread and the one that changes the state make.
#include "call-queue.hpp"

#include "eventually.hpp"
#include "gst-raii.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <gtest/gtest.h>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using test::eventually;

class Calls : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }
  void TearDown() override { queue_.finish(); }

  haptic::ElementPtr owner_{GST_ELEMENT(gst_object_ref_sink(gst_bin_new(nullptr)))};
  haptic::CallQueue queue_{owner_.get()};
};

// A call begins at once when the one before it has ended: that end counts as its begin.
TEST_F(Calls, OnlyACallThatLasts100MillisecondsIsOvertakenHoweverManyAreLeft) {
  constexpr std::size_t kCalls = 30;
  std::mutex mutex;
  std::vector<Clock::time_point> ends = {Clock::now()};
  std::size_t begun = 0;
  std::optional<Clock::duration> overtaken_after; // the first one
  const auto call = [&] {
    {
      const std::lock_guard lock(mutex);
      if (ends.size() != ++begun && !overtaken_after)
        overtaken_after = Clock::now() - ends.back();
    }
    std::this_thread::sleep_for(10ms);
    const std::lock_guard lock(mutex);
    ends.push_back(Clock::now());
  };
  for (std::size_t i = 0; i < kCalls; ++i)
    queue_.add(call);
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return begun > 0;
  }));
  queue_.drain();
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return ends.size() == 1 + kCalls;
  }));
  EXPECT_GE(overtaken_after.value_or(1s), 100ms);
}

TEST_F(Calls, ACallThatDoesNotEndIsOvertakenByAllThatAreLeft) {
  std::atomic<bool> begun = false;
  std::atomic<bool> may_end = false;
  std::atomic<bool> ended = false;
  std::vector<int> made;
  queue_.add([&] {
    begun = true;
    eventually([&] { return may_end.load(); });
    ended = true;
  });
  EXPECT_TRUE(eventually([&] { return begun.load(); }));
  for (int i = 0; i < 20; ++i) // of which each would wait in vain
    queue_.add([&, i] { made.push_back(i); });
  queue_.drain();
  EXPECT_FALSE(ended);
  EXPECT_EQ(made.size(), 20U);
  EXPECT_TRUE(std::ranges::is_sorted(made));
  may_end = true;
  EXPECT_TRUE(eventually([&] { return ended.load(); }));
}

} // namespace
