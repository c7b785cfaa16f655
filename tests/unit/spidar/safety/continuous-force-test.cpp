// SPDX-License-Identifier: LGPL-2.1-or-later
// The budget for continuous force: the rms over any 60 s, by itself and in the safety chain.
#include "safety/continuous-force.hpp"

#include "device-limits.hpp"
#include "safety/safety-chain.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace continuous_force_test {

using haptic::ContinuousForce;
using haptic::SafetyChain;

constexpr double kTick = 0.001;     // s
constexpr double kTolerance = 1e-3; // of the budget: the window counts up to 60.1 s
constexpr double kSlewRate = 20;    // N/s

using Demand = std::function<double(double)>; // N at a time in s

SafetyChain::Input push(double force, double budget) {
  SafetyChain::Input input;
  input.wanted.force = {force, 0, 0};
  input.measured = true;
  input.trust = 1;
  input.interval = 1.0 / 30;
  input.max_force = 5;
  input.slew_rate = kSlewRate;
  input.continuous_force = budget;
  input.dt = kTick;
  return input;
}

// The forces of a chain, 1000 a second, N. No step may exceed the slew limit.
std::vector<double> run(const Demand &demand, double budget, int seconds) {
  SafetyChain chain{test::kSpidar};
  std::vector<double> forces;
  double before = 0;
  for (int ms = 0; ms < seconds * 1000; ++ms) {
    const double force = chain.step(push(demand(ms * kTick), budget)).force.x();
    EXPECT_LE(std::abs(force - before), kSlewRate * kTick + 1e-12) << ms;
    before = force;
    forces.push_back(force);
  }
  return forces;
}

// The largest rms over any 60 s, N.
double largest_rms(const std::vector<double> &forces) {
  constexpr std::size_t kWindow = 60'000;
  double sum = 0;
  double most = 0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    sum += forces[i] * forces[i];
    if (i >= kWindow)
      sum -= forces[i - kWindow] * forces[i - kWindow];
    most = std::max(most, sum);
  }
  return std::sqrt(most / kWindow);
}

TEST(ContinuousForceBudget, IsNeverExceededOverAMinuteWhateverTheDemand) {
  std::mt19937 random(14);
  std::uniform_real_distribution<double> any(-5, 5);
  double held = 0;
  const Demand kDemands[] = {
      [](double) { return 5.0; },
      [](double) { return 1.2; },
      [](double t) { return std::fmod(t, 10) < 5 ? 5.0 : 0.0; },
      [](double t) { return std::fmod(t, 70) < 10 ? 3.0 : 0.5; },
      [](double t) { return 4 * std::sin(t); },
      [&](double) { return random() % 500 == 0 ? held = any(random) : held; },
  };
  for (const double budget : {0.3, 1.0, 2.0})
    for (const Demand &demand : kDemands)
      EXPECT_LE(largest_rms(run(demand, budget, 150)), budget * (1 + kTolerance)) << budget;
}

TEST(ContinuousForceBudget, AForceUpToTheBudgetIsNeverLimited) {
  const auto forces = run([](double) { return 1.0; }, 1, 200);
  EXPECT_NEAR(*std::min_element(forces.begin() + 1000, forces.end()), 1, 1e-9);
}

TEST(ContinuousForceBudget, APeakOfFiveTimesTheBudgetFadesToWhatCanBeKept) {
  const auto forces = run([](double) { return 5.0; }, 1, 130);
  EXPECT_GT(*std::max_element(forces.begin(), forces.end()), 4);
  for (std::size_t ms = 10'000; ms < 58'000; ++ms)
    ASSERT_NEAR(forces[ms], 0.74, 0.02) << ms;
  EXPECT_NEAR(forces[65'000], 1, 0.02); // the peak has left the window
}

TEST(ContinuousForceBudget, AMinuteOfRestGivesTheWholePeakBack) {
  const auto forces = run([](double t) { return std::fmod(t, 90) < 20 ? 5.0 : 0.0; }, 1, 200);
  const auto peak = [&](std::size_t second) {
    const auto from = forces.begin() + static_cast<std::ptrdiff_t>(second * 1000);
    return *std::max_element(from, from + 10'000);
  };
  EXPECT_NEAR(peak(90), peak(0), 0.01);
  EXPECT_NEAR(peak(180), peak(0), 0.01);
}

TEST(ContinuousForceBudget, OffItLimitsNothing) {
  const auto forces = run([](double) { return 5.0; }, 0, 100);
  EXPECT_EQ(forces.back(), 5);
}

TEST(ContinuousForceBudget, SetUnderAForceItFadesAtTheSlewRate) {
  SafetyChain chain{test::kSpidar};
  for (int ms = 0; ms < 60'000; ++ms)
    chain.step(push(5, 0));
  double before = 5;
  for (int ms = 0; ms < 1000; ++ms) {
    const double force = chain.step(push(5, 1)).force.x();
    ASSERT_LE(before - force, kSlewRate * kTick + 1e-12);
    before = force;
  }
  EXPECT_EQ(before, 0); // 25 times the budget is used up
}

TEST(ContinuousForceBudget, ARestartOfTheChainGivesNothingBack) {
  SafetyChain chain{test::kSpidar};
  std::vector<double> forces;
  for (int ms = 0; ms < 60'000; ++ms) {
    if (ms % 3000 == 0)
      chain.restart();
    forces.push_back(chain.step(push(5, 1)).force.x());
  }
  EXPECT_LE(largest_rms(forces), 1 + kTolerance);
}

TEST(ContinuousForceBudget, IsKeptByLateTicksAndAWholeMinuteOfSilence) {
  ContinuousForce force;
  std::mt19937 random(15);
  double sum = 0; // N²·s
  double limit = force.step(0, 1, 0);
  for (double time = 0; time < 59;) {
    const double dt = random() % 20 == 0 ? 0.02 : kTick;
    const double acted = std::min(limit, 5.0);
    limit = force.step(acted, 1, dt);
    sum += acted * acted * dt;
    time += dt;
  }
  EXPECT_LE(sum, 60 * (1 + kTolerance));
  force.step(0, 1, 1e9);
  EXPECT_EQ(force.rms(), 0);
  EXPECT_GT(force.step(0, 1, 5), 4.9);
}

TEST(ContinuousForceBudget, TellsTheRmsAndTheShareThatIsUsed) {
  ContinuousForce force;
  for (int ms = 0; ms < 30'000; ++ms)
    force.step(0.8, 1, kTick);
  EXPECT_NEAR(force.used(), 0.64 / 2, 0.002);
  EXPECT_NEAR(force.rms(), 0.8 / std::sqrt(2), 0.002);
  for (int ms = 0; ms < 31'000; ++ms)
    force.step(0.8, 1, kTick);
  EXPECT_NEAR(force.rms(), 0.8, 0.002);
  force.step(0.8, 0, kTick);
  EXPECT_EQ(force.used(), 0);
}

TEST(ContinuousForceBudget, TheHoldsOfTheChainSayWhenItLimits) {
  SafetyChain chain{test::kSpidar};
  for (int ms = 0; ms < 500; ++ms)
    chain.step(push(2, 1));
  EXPECT_EQ(chain.holds(), 0U);
  for (int ms = 0; ms < 10'000; ++ms)
    chain.step(push(5, 1));
  EXPECT_EQ(chain.holds(), haptic::kHoldSpent);
  chain.step(push(0.5, 1));
  EXPECT_EQ(chain.holds(), 0U);
}

} // namespace continuous_force_test
