// SPDX-License-Identifier: LGPL-2.1-or-later
// Timing of the 1 kHz loop with the simulated device, as hapticsink runs it. Run by hand on an idle
// machine:
//   BUILD/tests/measure/benchmarks/hapticsink-loop [SECONDS]
// Targets: no tick missed (more than 10 ms late) in 60 s, loop body p99 <= 20 us; of it 1 us for a
// field and 0.5 us for the flight recorder; the loop's own part of a tick, without the controller's
// exchange, p99 <= 15 us, with a hand that touches 20 us; nothing taken from the heap in any tick.
#include "counted-allocations.hpp"
#include "drivers/device-choice.hpp"
#include "loop/haptic-loop.hpp"
#include "processor.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <pthread.h>
#include <spidar/device.hpp>
#include <spidar/simulator.hpp>
#include <string>
#include <thread>
#include <unistd.h>

namespace {

constexpr double kDefaultSeconds = 60;
constexpr auto kFrame = std::chrono::nanoseconds(std::chrono::seconds(1)) / 30;

haptic::MotionSample leaf(double t) {
  haptic::MotionSample sample;
  sample.velocity_x = static_cast<float>(150 * std::sin(7 * t));
  sample.velocity_y = static_cast<float>(80 * std::sin(14 * t));
  sample.confidence = 1;
  sample.interval = static_cast<std::uint64_t>(kFrame.count());
  sample.frame_width = 352;
  sample.frame_height = 288;
  return sample;
}

// A controller that knows how long its exchanges took: on USB that is waiting.
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

// Waves that move under the hand, as fine as depthfield makes them by default.
haptic::ReliefField waves(double t) {
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

// The time of each tick without the exchange, with the log on, in a thread like the loop's. Returns
// how often the ticks took memory from the heap. `touch`: the hand rests in waves, too.
long measure_own_part(double seconds, const std::string &log_path, bool touch,
                      haptic::DurationHistogram &own) {
  const auto pool = std::make_unique<haptic::ReliefPool>();
  const spidar::Geometry geometry = spidar::load_geometry(spidar::kDefaultGeometry);
  auto timed = std::make_unique<TimedController>(
      std::make_unique<spidar::Simulator>(geometry, spidar::parse_hand_script("circle:0.6,5")));
  const TimedController &controller = *timed;
  spidar::Device device(std::move(timed), geometry);
  haptic::TickLog log(log_path);
  haptic::HapticLoop loop;
  haptic::LoopSettings settings;
  settings.touch = touch ? haptic::TouchMode::surface_and_motion : haptic::TouchMode::off;
  loop.set_settings(settings);
  loop.prepare({.device = &device, .log = &log, .records = true});
  loop.unhold(haptic::kHoldClosed | haptic::kHoldPaused);
  long allocations = 0;
  std::jthread([&] {
    const sched_param wanted{.sched_priority = 50};
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
    long taken = 0;
    std::int64_t next = haptic::monotonic_now();
    for (int tick = 0; tick < seconds * 1000; ++tick) {
      next += 1'000'000;
      const timespec at{.tv_sec = next / 1'000'000'000, .tv_nsec = next % 1'000'000'000};
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
      if (tick % 33 == 0)
        loop.submit(leaf(tick * 1e-3));
      if (touch && tick % 33 == 0) {
        auto relief = pool->acquire();
        if (relief) {
          *relief = waves(tick * 1e-3);
          loop.submit(haptic::TimedRelief{std::move(relief)});
        }
      }
      const long before = test::allocations;
      const std::int64_t now = haptic::monotonic_now();
      loop.tick(next, now);
      own.record(haptic::monotonic_now() - now - controller.taken);
      taken += test::allocations - before;
    }
    allocations = taken;
  }).join();
  return allocations;
}

// ns that a tick spends on a field: it is sampled at both ends of the line that the tick is on.
double field_cost(std::uint16_t columns, std::uint16_t rows, double z) {
  constexpr int kTicks = 20'000;
  haptic::MotionField field;
  field.frame_width = 1920;
  field.frame_height = 1080;
  field.columns = columns;
  field.rows = rows;
  field.cells.assign(std::size_t{columns} * rows, {100, 50, 0.9F});
  const haptic::MotionField next = field;
  float sum = 0;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kTicks; ++i) {
    const haptic::PointerPosition place{.x = 0.5 + 0.4 * std::sin(0.01 * i), .y = 0.5, .z = z};
    sum += haptic::sample_field(field, place).velocity_x;
    sum += haptic::sample_field(next, place).velocity_x;
  }
  const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
  return sum > 0 ? taken.count() / kTicks : 0;
}

// ns that a tick spends to be recorded.
double record_cost() {
  constexpr int kTicks = 1'000'000;
  haptic::FlightRecorder recorder(1000);
  haptic::TickRow row{};
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kTicks; ++i) {
    row.time = i;
    recorder.record(row, i % 2 == 0);
  }
  const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
  return taken.count() / kTicks;
}

} // namespace

int main(int argc, char **argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : kDefaultSeconds;
  const std::string path = "/tmp/hapticsink-loop-" + std::to_string(getpid()) + ".csv";
  haptic::HapticLoop loop;
  long before = 0;
  long allocations = 0;
  {
    const auto opened = haptic::open_device({.device = "sim", .sim_hand = "circle:0.6,5"});
    haptic::TickLog log(path);
    loop.start({.device = opened.device.get(),
                .log = &log,
                .records = true,
                .callbacks = {.entered = [&] { before = test::allocations; },
                              .left = [&] { allocations = test::allocations - before; }}});
    loop.unhold(haptic::kHoldClosed | haptic::kHoldPaused);
    const auto start = std::chrono::steady_clock::now();
    auto next = start;
    for (double t = 0; t < seconds; t += 1.0 / 30) {
      loop.submit(leaf(t));
      std::this_thread::sleep_until(next += kFrame);
    }
    loop.stop();
  }
  haptic::DurationHistogram own;
  haptic::DurationHistogram touching;
  allocations += measure_own_part(std::min(seconds, 20.0), path, false, own);
  allocations += measure_own_part(std::min(seconds, 20.0), path, true, touching);
  std::remove(path.c_str());

  const haptic::LoopStatistics &s = loop.statistics();
  std::printf("%s, %ld processors, compiler %s, %.0f s with the log on\n",
              test::processor().c_str(), sysconf(_SC_NPROCESSORS_ONLN), __VERSION__, seconds);
  std::printf("real-time priority: %s\n", loop.thread().priority_error() == 0
                                              ? "yes"
                                              : std::strerror(loop.thread().priority_error()));
  std::printf("ticks %lu, late by a period %lu, missed (10 ms) %lu, log rows lost %lu\n",
              s.ticks.load(), s.late_ticks.load(), s.missed_ticks.load(), s.log_rows_lost.load());
  std::printf("lateness  p50 %8.1f us  p99 %8.1f us  p99.9 %8.1f us  max %8.1f us\n",
              s.lateness.percentile_us(0.5), s.lateness.percentile_us(0.99),
              s.lateness.percentile_us(0.999), s.lateness.max_us());
  std::printf("loop body p50 %8.1f us  p99 %8.1f us  p99.9 %8.1f us  max %8.1f us\n",
              s.body.percentile_us(0.5), s.body.percentile_us(0.99), s.body.percentile_us(0.999),
              s.body.max_us());
  std::printf("own part  p50 %8.1f us  p99 %8.1f us  p99.9 %8.1f us  max %8.1f us\n",
              own.percentile_us(0.5), own.percentile_us(0.99), own.percentile_us(0.999),
              own.max_us());
  std::printf("touching  p50 %8.1f us  p99 %8.1f us  p99.9 %8.1f us  max %8.1f us\n",
              touching.percentile_us(0.5), touching.percentile_us(0.99),
              touching.percentile_us(0.999), touching.max_us());
  std::printf("taken from the heap in all ticks: %ld times\n", allocations);
  std::printf("sample age mean %.3f ms, largest force %.3f N\n",
              static_cast<double>(s.sample_age_sum) * 1e-6 /
                  static_cast<double>(std::max<std::uint64_t>(s.samples_used, 1)),
              s.force_max.load());
  std::printf(
      "field, 32x18 cells: %.0f ns with the hand in the centre, %.0f ns pulled close; 128x64 cells "
      "pulled close: %.0f ns\n",
      field_cost(32, 18, 0), field_cost(32, 18, 1), field_cost(128, 64, 1));
  const double recorded = record_cost();
  std::printf("flight recorder: %.0f ns\n", recorded);
  const bool fast = s.body.percentile_us(0.99) <= 20 && own.percentile_us(0.99) <= 15 &&
                    touching.percentile_us(0.99) <= 20 && recorded <= 500;
  return s.missed_ticks == 0 && fast && allocations == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
