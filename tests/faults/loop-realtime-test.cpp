// SPDX-License-Identifier: LGPL-2.1-or-later
// The loop's thread among all the others, by the clock of the machine. Only limits and the final
// state are asserted.
#include "loop-fixture.hpp"

#include <chrono>
#include <random>
#include <thread>

namespace {

using namespace std::chrono_literals;
using test::kMs;
using test::Loop;
using test::moving;

// For ThreadSanitizer, too: every thread that the element has, at once.
TEST_F(Loop, F23_AStormFromEveryThreadLeavesTheForceWithinItsLimitsAndItComesBack) {
  open();
  loop_.start({.device = device_.get()});
  play();
  {
    std::jthread properties([&](const std::stop_token &stop) {
      std::mt19937 random(1);
      std::uniform_real_distribution<double> fraction(0, 1);
      while (!stop.stop_requested()) {
        haptic::LoopSettings settings;
        settings.law = random() % haptic::force_laws().size();
        settings.law_settings.max_force = 5 * fraction(random);
        settings.law_settings.alpha = 10 * fraction(random);
        settings.law_settings.gain_window = 0.1 + 600 * fraction(random);
        settings.law_settings.max_push = 5 * fraction(random);
        settings.smooth_hz = 500 * fraction(random);
        settings.damping = 10 * fraction(random);
        loop_.set_settings(settings);
        std::this_thread::sleep_for(100us);
      }
    });
    std::jthread streaming([&](const std::stop_token &stop) {
      std::mt19937 random(2);
      std::uniform_real_distribution<float> velocity(-1000, 1000);
      while (!stop.stop_requested()) {
        loop_.submit(moving(velocity(random), velocity(random)));
        if (random() % 16 == 0)
          loop_.submit_gap();
        std::this_thread::sleep_for(1ms);
      }
    });
    std::jthread application([&](const std::stop_token &stop) {
      std::mt19937 random(3);
      while (!stop.stop_requested()) {
        const std::uint32_t hold = 1U << (random() % 6);
        loop_.hold(hold);
        loop_.drop_samples();
        loop_.calibrate();
        loop_.set_running_time(haptic::monotonic_now(), static_cast<std::int64_t>(random()) * kMs);
        loop_.unhold(hold);
        std::this_thread::sleep_for(2ms);
      }
    });
    std::jthread pointer([&](const std::stop_token &stop) {
      while (!stop.stop_requested()) {
        loop_.hand();
        loop_.statistics().body.percentile_us(0.99);
        std::this_thread::sleep_for(500us);
      }
    });
    std::this_thread::sleep_for(1s);
  }
  EXPECT_LE(force_max(), 5 + 1e-9);

  // In the storm itself, a slow machine may find no 10 ms without a hold.
  const auto wait_until = [&](const auto &condition) {
    while (!condition()) {
      loop_.submit(moving(1000, 0));
      std::this_thread::sleep_for(1ms);
    }
  };
  loop_.set_settings({});
  loop_.hold(haptic::kHoldPaused);
  wait_until([&] { return loop_.silent(); });
  loop_.unhold(haptic::kHoldPaused | haptic::kLatches);
  wait_until([&] { return !loop_.silent() && force_max() > 0.01; }); // it is felt
  loop_.stop();
}

} // namespace
