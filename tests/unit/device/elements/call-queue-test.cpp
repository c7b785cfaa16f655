// SPDX-License-Identifier: LGPL-2.1-or-later
// Calls of handlers, which the pool's thread and the one that changes the state make.
#include "elements/call-queue.hpp"

#include "glue/gst-raii.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

namespace call_queue_test {

using namespace std::chrono_literals;
using haptic::CallQueue;
using Clock = CallQueue::Clock;

/// Passes only as a test lets it, or where somebody waits in vain.
class TestTime final : public CallQueue::Time {
public:
  Clock::time_point now() const override { return now_; }
  bool wait_until(std::condition_variable &changed, std::unique_lock<std::mutex> &lock,
                  Clock::time_point deadline, const std::function<bool()> &done) override {
    if (waits_in_vain && !done())
      now_ = deadline;
    waiting_ = &changed;
    changed.wait(lock, [&] { return done() || now() >= deadline; });
    waiting_ = nullptr;
    return done();
  }
  void pass(Clock::duration time) {
    now_ = now() + time;
    if (std::condition_variable *const waiting = waiting_)
      waiting->notify_all();
    std::this_thread::yield(); // to the one that waits
  }

  std::atomic<bool> waits_in_vain = false;

private:
  std::atomic<Clock::time_point> now_{Clock::time_point()};
  std::atomic<std::condition_variable *> waiting_ = nullptr;
};

class Calls : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  TestTime time_;
  haptic::ElementPtr owner_{GST_ELEMENT(gst_object_ref_sink(gst_bin_new(nullptr)))};
  CallQueue queue_{owner_.get(), time_};
};

TEST_F(Calls, OnlyACallThatLasts100MillisecondsIsOvertakenHoweverManyAreLeft) {
  constexpr std::size_t kCalls = 30;
  std::promise<void> begun;
  std::atomic<std::size_t> ended = 0;
  std::atomic<int> under_way = 0;
  std::atomic<bool> overtaken = false;
  queue_.add([&] { begun.set_value(); });
  for (std::size_t i = 0; i < kCalls; ++i)
    queue_.add([&] {
      if (++under_way > 1)
        overtaken = true;
      time_.pass(99ms);
      --under_way;
      ++ended;
    });
  begun.get_future().wait();
  queue_.drain();
  queue_.finish();
  EXPECT_EQ(ended, kCalls);
  EXPECT_FALSE(overtaken);
}

TEST_F(Calls, ACallThatDoesNotEndIsOvertakenByAllThatAreLeft) {
  std::promise<void> begun;
  std::promise<void> may_end;
  std::promise<void> ended;
  std::vector<int> made;
  queue_.add([&] {
    begun.set_value();
    may_end.get_future().wait();
    ended.set_value();
  });
  begun.get_future().wait();
  time_.waits_in_vain = true;
  for (int i = 0; i < 20; ++i) // of which each would wait in vain
    queue_.add([&, i] { made.push_back(i); });
  const auto begin = time_.now();
  queue_.drain();
  EXPECT_EQ(made.size(), 20U);
  EXPECT_TRUE(std::ranges::is_sorted(made));
  EXPECT_EQ(time_.now() - begin, 100ms) << "once for all";
  time_.waits_in_vain = false;
  may_end.set_value();
  ended.get_future().wait();
  queue_.finish();
}

// Threads that go on arming and releasing would otherwise hold up a change of the state for ever.
TEST_F(Calls, OnlyTheCallsThatAreThereAtTheBeginningAreDrained) {
  std::promise<void> begun;
  std::promise<void> may_end;
  std::promise<void> ended;
  std::atomic<int> made = 0;
  queue_.add([&] {
    begun.set_value();
    may_end.get_future().wait();
  });
  begun.get_future().wait();
  time_.waits_in_vain = true;
  const std::function<void()> add_another = [&] {
    if (++made < 100)
      queue_.add(add_another);
    else
      ended.set_value();
  };
  queue_.add(add_another);
  queue_.drain();
  EXPECT_EQ(made, 1);
  time_.waits_in_vain = false;
  may_end.set_value();
  ended.get_future().wait();
  queue_.finish();
}

} // namespace call_queue_test
