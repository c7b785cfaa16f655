// SPDX-License-Identifier: LGPL-2.1-or-later
// Times of the pose solver, the tension solver and one whole tick. Run by hand on an idle machine:
//   BUILD/tests/measure/benchmarks/spidar-benchmark
// Each call is timed alone; the counters p50_us, p99_us and max_us are over all calls and contain
// the clock's own some 0.03 us.
#include "spidar/device.hpp"
#include "spidar/pose-solver.hpp"
#include "spidar/simulator.hpp"
#include "spidar/tension-solver.hpp"

#include <algorithm>
#include <benchmark/benchmark.h>
#include <chrono>
#include <cmath>
#include <Eigen/Geometry>
#include <numbers>
#include <random>
#include <string>
#include <vector>

using namespace spidar;

namespace {

constexpr int kCalls = 200000;
constexpr int kCases = 40000;
constexpr double kDegree = std::numbers::pi / 180;

class Random {
public:
  double between(double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(engine_);
  }
  Vector3 in_box(double half) {
    return {between(-half, half), between(-half, half), between(-half, half)};
  }
  Vector3 direction() {
    std::normal_distribution<double> normal;
    return Vector3(normal(engine_), normal(engine_), normal(engine_)).normalized();
  }
  Pose pose() {
    return {in_box(0.025),
            Eigen::AngleAxisd(between(0, 20 * kDegree), direction()).toRotationMatrix()};
  }

private:
  std::mt19937 engine_{1};
};

/// A hand that wanders through the workspace, `t` in s.
Pose wandering(double t) {
  return {0.025 * Vector3(std::sin(2.1 * t), std::sin(1.7 * t + 1), std::sin(1.3 * t + 2)),
          Eigen::AngleAxisd(20 * kDegree * std::sin(1.1 * t),
                            Vector3(std::sin(0.9 * t), std::cos(0.7 * t), 0.5).normalized())
              .toRotationMatrix()};
}

template <class Call>
void time_calls(benchmark::State &state, Call &&call) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times;
  times.reserve(kCalls);
  std::size_t i = 0;
  for (auto _ : state) {
    const auto begin = Clock::now();
    call(i++);
    const auto end = Clock::now();
    const double seconds = std::chrono::duration<double>(end - begin).count();
    state.SetIterationTime(seconds);
    times.push_back(1e6 * seconds);
  }
  std::sort(times.begin(), times.end());
  const auto percentile = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  state.counters["p50_us"] = percentile(0.5);
  state.counters["p99_us"] = percentile(0.99);
  state.counters["max_us"] = times.back();
}

void pose_while_wandering(benchmark::State &state) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  const PoseSolver solver(geometry);
  std::vector<StringLengths> lengths;
  for (int i = 0; i < kCases; ++i)
    lengths.push_back(string_lengths(geometry, wandering(0.001 * i)));
  Pose pose = wandering(0);
  time_calls(state, [&](std::size_t i) { pose = solver.solve(lengths[i % kCases], pose).pose; });
}

void pose_after_a_step(benchmark::State &state) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  const PoseSolver solver(geometry);
  Random random;
  std::vector<StringLengths> lengths;
  for (int i = 0; i < kCases; ++i)
    lengths.push_back(string_lengths(
        geometry, {0.014 * random.direction(),
                   Eigen::AngleAxisd(20 * kDegree, random.direction()).toRotationMatrix()}));
  time_calls(state, [&](std::size_t i) {
    benchmark::DoNotOptimize(solver.solve(lengths[i % kCases], {}));
  });
}

void tension_while_wandering(benchmark::State &state) {
  TensionSolver solver(load_geometry(kDefaultGeometry));
  std::vector<std::pair<Wrench, Pose>> cases;
  for (int i = 0; i < kCases; ++i) {
    const double t = 0.001 * i;
    const double size = 0.5 + 0.5 * std::sin(5 * t);
    cases.push_back(
        {{size * Vector3(std::cos(7 * t), std::sin(7 * t), 0), Vector3::Zero()}, wandering(t)});
  }
  time_calls(state, [&](std::size_t i) {
    const auto &[wrench, pose] = cases[i % kCases];
    benchmark::DoNotOptimize(solver.solve(wrench, pose));
  });
}

/// Poses and forces without any relation between one call and the next: the warm start misleads.
void tension_at_random(benchmark::State &state) {
  TensionSolver solver(load_geometry(kDefaultGeometry));
  Random random;
  std::vector<std::pair<Wrench, Pose>> cases;
  const auto largest = static_cast<double>(state.range(0));
  for (int i = 0; i < kCases; ++i)
    cases.push_back(
        {{random.between(0, largest) * random.direction(), Vector3::Zero()}, random.pose()});
  time_calls(state, [&](std::size_t i) {
    const auto &[wrench, pose] = cases[i % kCases];
    benchmark::DoNotOptimize(solver.solve(wrench, pose));
  });
}

/// Exchange with the simulator, pose, tensions: what the 1 kHz loop does with the device.
void whole_tick(benchmark::State &state) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Device device(std::make_unique<Simulator>(geometry, parse_hand_script("circle:0.8,4")), geometry);
  time_calls(state, [&](std::size_t i) {
    const double angle = 0.007 * static_cast<double>(i);
    device.exchange(static_cast<std::int64_t>(i) * 1'000'000);
    device.command({Vector3(std::cos(angle), std::sin(angle), 0), Vector3::Zero()});
  });
}

BENCHMARK(pose_while_wandering)->Iterations(kCalls)->UseManualTime();
BENCHMARK(pose_after_a_step)->Iterations(kCalls)->UseManualTime();
BENCHMARK(tension_while_wandering)->Iterations(kCalls)->UseManualTime();
BENCHMARK(tension_at_random)->Arg(1)->Arg(20)->Iterations(kCalls)->UseManualTime();
BENCHMARK(whole_tick)->Iterations(kCalls)->UseManualTime();

} // namespace

int main(int argc, char **argv) {
  benchmark::AddCustomContext("compiler", "C++ " __VERSION__);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
    return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
