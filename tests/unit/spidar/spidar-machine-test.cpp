// SPDX-License-Identifier: LGPL-2.1-or-later
// The verdict on a machine, from given times.
#include "spidar/machine.hpp"

#include "device-limits.hpp"

#include <gtest/gtest.h>
#include <string>

namespace spidar_machine_test {

using namespace spidar;

constexpr double kMs = 1e-3; // s

MachineTiming in_time() {
  return {.priority = true,
          .lateness = {0.05 * kMs, 0.1 * kMs},
          .loaded = Lateness{0.06 * kMs, 0.15 * kMs},
          .device = test::kSpidar};
}

void expect_verdict(const MachineTiming &timing, Fitness fitness,
                    std::initializer_list<const char *> words) {
  const MachineVerdict verdict = judge_machine(timing);
  EXPECT_EQ(verdict.fitness, fitness) << verdict.text;
  for (const char *word : words)
    EXPECT_NE(verdict.text.find(word), std::string::npos) << word << " in " << verdict.text;
  EXPECT_EQ(verdict.text.find('\n'), std::string::npos);
}

TEST(MachineVerdict, AMachineWhoseTicksComeWithinAPeriodIsFit) {
  expect_verdict(in_time(), Fitness::fit, {"is fit for a force:", "0.15 ms late", "174 N/m"});
  MachineTiming timing = in_time();
  timing.priority = false; // what counts is the time
  timing.round_trip = 0.9 * kMs;
  expect_verdict(timing, Fitness::fit, {});
}

TEST(MachineVerdict, ATickThatIsLaterThanAPeriodLimitsTheStiffness) {
  MachineTiming timing = in_time();
  timing.lateness.worst = 4 * kMs;
  expect_verdict(timing, Fitness::limited,
                 {"with limits: a tick with real-time priority came 4.0 ms late",
                  "at most 40 N/m instead of 200 N/m", "PREEMPT"});
  timing.priority = false;
  expect_verdict(timing, Fitness::limited, {"without real-time priority", "Install rtkit"});
  timing = in_time();
  timing.loaded->worst = 4 * kMs;
  expect_verdict(timing, Fitness::limited,
                 {"while other programs kept the processors busy, a tick", "40 N/m"});
  timing.loaded.reset();
  expect_verdict(timing, Fitness::fit, {});
}

TEST(MachineVerdict, ATickThatHoldsTheForceMakesTheMachineUnfitUnlessOnlyOthersCauseIt) {
  MachineTiming timing = in_time();
  timing.lateness.worst = 10.1 * kMs;
  expect_verdict(timing, Fitness::unfit, {"is not fit for a force:", "10.1 ms late", "10 ms"});
  timing.lateness.worst = 9.9 * kMs;
  expect_verdict(timing, Fitness::limited, {"18 N/m"});
  timing = in_time();
  timing.loaded->worst = 25 * kMs;
  expect_verdict(timing, Fitness::limited,
                 {"while other programs kept the processors busy", "the force stops after 10 ms"});
}

TEST(MachineVerdict, AnExchangeMustFitIntoATick) {
  MachineTiming timing = in_time();
  timing.round_trip = 1.25 * kMs;
  expect_verdict(timing, Fitness::limited, {"takes 1.2 ms", "rate can be 800 Hz", "hub"});
  timing.period = 2 * kMs;
  expect_verdict(timing, Fitness::fit, {});
  timing.round_trip = 2.1 * kMs;
  expect_verdict(timing, Fitness::unfit, {"takes 2.1 ms", "hub"});
}

TEST(MachineVerdict, TheGravestDecides) {
  MachineTiming timing = in_time();
  timing.lateness.worst = 4 * kMs;
  timing.loaded->worst = 25 * kMs;
  expect_verdict(timing, Fitness::limited, {"the force stops"});
  timing.lateness.worst = 12 * kMs;
  expect_verdict(timing, Fitness::unfit, {"12.0 ms"});
  timing.round_trip = 3 * kMs;
  expect_verdict(timing, Fitness::unfit, {"exchange"});
}

TEST(MachineVerdict, IsThatOfTheDevice) {
  MachineTiming timing = in_time();
  timing.lateness.worst = 4 * kMs;
  timing.device = test::kArm; // a touch of 200 N/m bears ticks 15 ms apart
  expect_verdict(timing, Fitness::fit, {"4.00 ms late, so a touch has up to 200 N/m."});
  timing.device = {}; // nothing can be touched
  expect_verdict(timing, Fitness::fit, {"no tick came more than 4.00 ms late."});
  timing.lateness.worst = 10.1 * kMs;
  expect_verdict(timing, Fitness::unfit, {"10.1 ms late"});
}

TEST(Lateness, IsThatOfNearlyAllTicksAndOfTheWorst) {
  std::vector<double> ticks(10'000, 0.1 * kMs);
  for (std::size_t i = 0; i < 9; ++i) // fewer than one in a thousand
    ticks[i * 1000] = 3 * kMs;
  ticks[17] = 7 * kMs;
  EXPECT_EQ(lateness_of(ticks).usual, 0.1 * kMs);
  EXPECT_EQ(lateness_of(ticks).worst, 7 * kMs);
  ticks[18] = ticks[19] = 2 * kMs;
  EXPECT_EQ(lateness_of(ticks).usual, 2 * kMs);
  EXPECT_EQ(lateness_of({}).worst, 0);
  EXPECT_EQ(lateness_of({-1}).worst, 0); // never early
}

TEST(StiffestTouch, FollowsTheLongestIntervalAndTheDevice) {
  EXPECT_DOUBLE_EQ(stiffest_touch(test::kSpidar, 0.0005), 200);
  EXPECT_DOUBLE_EQ(stiffest_touch(test::kSpidar, 0.001), 200);
  EXPECT_DOUBLE_EQ(stiffest_touch(test::kSpidar, 0.008), 25); // docs/force.md#touch
  EXPECT_DOUBLE_EQ(stiffest_touch(test::kArm, 0.008), 200);
  EXPECT_DOUBLE_EQ(stiffest_touch(test::kArm, 0.02), 150);
  EXPECT_EQ(stiffest_touch({}, 0.001), 0);
}

} // namespace spidar_machine_test
