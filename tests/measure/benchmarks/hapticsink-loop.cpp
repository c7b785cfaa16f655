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
#include "timed-loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <unistd.h>

namespace {

constexpr double kDefaultSeconds = 60;

// The time of each tick without the exchange, with the log on, in a thread like the loop's. Returns
// how often the ticks took memory from the heap. `touch`: the hand rests in waves, too.
long measure_own_part(double seconds, bool touch, haptic::DurationHistogram &own) {
  test::TimedLoop loop(touch);
  long allocations = 0;
  std::jthread([&] {
    test::take_priority_of_loop();
    long taken = 0;
    std::int64_t next = haptic::monotonic_now();
    for (int tick = 0; tick < seconds * 1000; ++tick) {
      next += test::kPeriod;
      test::wait_until(next);
      const std::int64_t now = haptic::monotonic_now();
      loop.submit(tick, now);
      const long before = test::allocations;
      own.record(loop.tick(next, now));
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
    const auto opened = haptic::open_device({.device = "sim", .sim_hand = test::kHandScript});
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
      loop.submit(test::swinging_leaf(t));
      std::this_thread::sleep_until(next += test::kFrame);
    }
    loop.stop();
  }
  haptic::DurationHistogram own;
  haptic::DurationHistogram touching;
  allocations += measure_own_part(std::min(seconds, 20.0), false, own);
  allocations += measure_own_part(std::min(seconds, 20.0), true, touching);
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
