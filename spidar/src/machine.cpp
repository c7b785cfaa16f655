// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/machine.hpp"

#include "fail.hpp"
#include "spidar/haptic-device.hpp"
#include "spidar/limited-device.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace spidar {

namespace {

constexpr double kHolds = std::chrono::duration<double>(kLongestSilence).count(); // s
// The lowest rate of hapticsink is 500 Hz. An exchange that takes longer fails, too.
constexpr double kSlowestTick = 0.002; // s

constexpr const char *kUnfit = "This machine is not fit for a force";
constexpr const char *kLimited = "This machine is fit for a force with limits";

double milliseconds(double seconds) {
  return seconds * 1e3;
}

/// `tick` and `then` are parts of a sentence.
MachineVerdict late(const MachineTiming &timing, Fitness fitness, double worst, const char *tick,
                    const std::string &then) {
  return {fitness,
          formatted(timing.priority ? messages::kMachineLate : messages::kMachineNoPriority,
                    fitness == Fitness::unfit ? kUnfit : kLimited, tick, milliseconds(worst),
                    then.c_str())};
}

MachineVerdict slow_device(Fitness fitness, double taken, const std::string &then) {
  return {fitness,
          formatted(messages::kMachineSlowUsb, fitness == Fitness::unfit ? kUnfit : kLimited,
                    milliseconds(taken), then.c_str())};
}

} // namespace

Lateness lateness_of(std::vector<double> ticks) {
  if (ticks.empty())
    return {};
  const std::size_t enough = (999 * ticks.size() + 999) / 1000; // rounded up
  const auto usual = ticks.begin() + static_cast<std::ptrdiff_t>(enough) - 1;
  std::nth_element(ticks.begin(), usual, ticks.end());
  return {std::max(*usual, 0.0), std::max(*std::max_element(usual, ticks.end()), 0.0)};
}

MachineVerdict judge_machine(const MachineTiming &timing) {
  const std::string stops = formatted("and the force stops after %.0f ms", milliseconds(kHolds));
  const double alone = timing.lateness.worst;
  const double busy = timing.loaded ? timing.loaded->worst : 0;
  const double worst = std::max(alone, busy);
  const double round_trip = timing.round_trip.value_or(0);
  constexpr const char *kAlone = "a tick";
  constexpr const char *kBusy = "while other programs kept the processors busy, a tick";

  if (round_trip > kSlowestTick)
    return slow_device(
        Fitness::unfit, round_trip,
        formatted("and the longest tick, of rate=500, is %.0f ms", milliseconds(kSlowestTick)));
  if (alone > kHolds)
    return late(timing, Fitness::unfit, alone, kAlone, stops);
  if (busy > kHolds)
    return late(timing, Fitness::limited, busy, kBusy, stops);
  if (round_trip > timing.period)
    return slow_device(
        Fitness::limited, round_trip,
        formatted("so the rate can be %.0f Hz at most", std::floor(1 / round_trip + 1e-6)));
  const double usual_touch = stiffest_touch(timing.device, timing.period);
  const double touch = stiffest_touch(timing.device, timing.period + worst);
  if (worst > timing.period && touch < usual_touch)
    return late(
        timing, Fitness::limited, worst, alone > timing.period ? kAlone : kBusy,
        formatted("so a touch has at most %.0f N/m instead of %.0f N/m", touch, usual_touch));
  const std::string in_time = formatted(
      "This machine is fit for a force: no tick came more than %.2f ms late", milliseconds(worst));
  if (!timing.device.knows_newtons())
    return {Fitness::fit, in_time + "."};
  return {Fitness::fit, formatted("%s, so a touch has up to %.0f N/m.", in_time.c_str(), touch)};
}

double stiffest_touch(const DeviceLimits &device, double longest) noexcept {
  // At the fastest hand that is not damped, the slew rate still follows the spring.
  constexpr double kFollowed = ForceLimits().slew_rate / ForceLimits::kUndamped;
  return std::min(kFollowed, device.stiffest_spring(longest));
}

} // namespace spidar
