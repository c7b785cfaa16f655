// SPDX-License-Identifier: LGPL-2.1-or-later
// The loop with the simulated device and the log on, as a measurement ticks it.
#pragma once

#include "loop/haptic-loop.hpp"

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <memory>
#include <pthread.h>
#include <spidar/device.hpp>
#include <spidar/simulator.hpp>
#include <string>
#include <unistd.h>
#include <utility>

namespace test {

inline constexpr auto kFrame = std::chrono::nanoseconds(std::chrono::seconds(1)) / 30;
inline constexpr std::int64_t kPeriod = 1'000'000; // ns
inline constexpr const char *kHandScript = "circle:0.6,5";

inline haptic::MotionSample swinging_leaf(double t) {
  haptic::MotionSample sample;
  sample.velocity_x = static_cast<float>(150 * std::sin(7 * t));
  sample.velocity_y = static_cast<float>(80 * std::sin(14 * t));
  sample.confidence = 1;
  sample.interval = static_cast<std::uint64_t>(kFrame.count());
  sample.frame_width = 352;
  sample.frame_height = 288;
  return sample;
}

/// Waves that move under the hand, as fine as depthfield makes them by default.
inline haptic::ReliefField waves(double t) {
  haptic::ReliefField relief;
  relief.interval = static_cast<std::uint64_t>(kFrame.count());
  relief.frame_width = 640;
  relief.frame_height = 480;
  relief.columns = 64;
  relief.rows = 48;
  for (int i = 0; i < 64 * 48; ++i) {
    const double height = 0.003 + 0.001 * std::sin(0.4 * (i % 64) + 0.3 * (i / 64) + 5 * t);
    relief.cells.push_back({static_cast<float>(height), 200, 0.3F, 1});
  }
  return relief;
}

/// A controller that knows how long its exchanges took: on USB that is waiting.
class TimedController final : public spidar::Controller {
public:
  explicit TimedController(std::unique_ptr<spidar::Controller> inner) : inner_(std::move(inner)) {}
  void set_time(std::int64_t now) noexcept override { inner_->set_time(now); }
  bool exchange(const spidar::DacWords &words, spidar::Counts &counts) noexcept override {
    const std::int64_t begun = haptic::monotonic_now();
    const bool answered = inner_->exchange(words, counts);
    taken = haptic::monotonic_now() - begun;
    return answered;
  }
  bool home(spidar::Counts &counts) const noexcept override { return inner_->home(counts); }
  std::string description() const override { return inner_->description(); }

  std::int64_t taken = 0; // ns, by the last exchange

private:
  std::unique_ptr<spidar::Controller> inner_;
};

/// A hand circles over the leaf. `touch`: it rests in waves, too.
class TimedLoop {
public:
  explicit TimedLoop(bool touch) : touch_(touch) {
    haptic::LoopSettings settings;
    settings.touch = touch ? haptic::TouchMode::surface_and_motion : haptic::TouchMode::off;
    loop_.set_settings(settings);
    haptic::HapticLoop::Environment environment;
    environment.device = &device_;
    environment.log = &log_;
    switch_recorder_on(environment);
    loop_.prepare(environment);
    loop_.unhold(haptic::kHoldClosed | haptic::kHoldPaused);
  }
  ~TimedLoop() { std::remove(log_path_.c_str()); }
  TimedLoop(const TimedLoop &) = delete;
  TimedLoop &operator=(const TimedLoop &) = delete;

  /// What a video submits before this tick, which begins at `now` (ns).
  void submit(int tick, std::int64_t now) {
    constexpr int kTicksPerFrame = 33;
    if (tick % kTicksPerFrame != 0)
      return;
    loop_.submit(swinging_leaf(tick * 1e-3), now);
    auto relief = touch_ ? pool_->acquire() : haptic::ReliefPool::Field{};
    if (!relief)
      return;
    *relief = waves(tick * 1e-3);
    loop_.submit(haptic::TimedRelief{std::move(relief)});
  }
  /// Returns how long the tick took without the exchange, ns.
  std::int64_t tick(std::int64_t scheduled, std::int64_t now) noexcept {
    const std::int64_t begun = haptic::monotonic_now();
    loop_.tick(scheduled, now);
    return haptic::monotonic_now() - begun - controller_->taken;
  }

private:
  // tick-cost.sh compiles this with an earlier loop, which may have no recorder.
  template <typename Environment>
  static void switch_recorder_on(Environment &environment) {
    if constexpr (requires { environment.records; })
      environment.records = true;
  }

  bool touch_;
  std::unique_ptr<haptic::ReliefPool> pool_ = std::make_unique<haptic::ReliefPool>();
  spidar::Geometry geometry_ = spidar::load_geometry(spidar::kDefaultGeometry);
  std::unique_ptr<TimedController> made_ = std::make_unique<TimedController>(
      std::make_unique<spidar::Simulator>(geometry_, spidar::parse_hand_script(kHandScript)));
  TimedController *controller_ = made_.get();
  spidar::Device device_{std::move(made_), geometry_};
  std::string log_path_ = "/tmp/timed-loop-" + std::to_string(getpid()) + ".csv";
  haptic::TickLog log_{log_path_};
  haptic::HapticLoop loop_;
};

/// This thread gets the priority of the loop's, if it may.
inline void take_priority_of_loop() {
  const sched_param wanted{.sched_priority = 50};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
}

inline void wait_until(std::int64_t time) {
  const timespec at{.tv_sec = time / 1'000'000'000, .tv_nsec = time % 1'000'000'000};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
}

} // namespace test
