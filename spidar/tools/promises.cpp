// SPDX-License-Identifier: LGPL-2.1-or-later
#include "promises.hpp"

#include "fail.hpp"

#include <array>
#include <cmath>
#include <csignal>
#include <limits>
#include <optional>
#include <spidar/usb.hpp>

namespace spidar_check {

using namespace std::chrono_literals;
using spidar::formatted;
using spidar::Vector3;
namespace messages = spidar::messages;

namespace {

constexpr const char *kAxes[] = {"x", "y", "z"};

Vector3 along(int axis, double length) {
  Vector3 vector = Vector3::Zero();
  vector[axis] = length;
  return vector;
}

// ---- The hand

constexpr double kMoved = 0.008;    // m
constexpr int kTimeToMove = 10'000; // ticks

/// Which way the grip went along `axis`: 1, -1, or 0 if it did not move enough.
int direction_moved(Unit &unit, int axis, double &moved) {
  unit.run(0.02, Vector3::Zero()); // the grip may have moved since the question
  const double begin = unit.state().pose.position[axis];
  for (int tick = 0; tick < kTimeToMove && unit.connected(); ++tick) {
    unit.tick(Vector3::Zero());
    moved = unit.state().pose.position[axis] - begin;
    if (unit.state().valid && std::abs(moved) > kMoved)
      return moved > 0 ? 1 : -1;
  }
  return 0;
}

// ---- The force

constexpr double kPhase = 0.4;    // s per direction, with the ramp
constexpr int kRounds = 2;        // a hand drifts
constexpr double kWrongBy = 0.02; // N, next to a tenth of the force: the D/A has steps
constexpr double kSeen = 1e-4;    // m
constexpr double kOneWord = 0.01; // N, more than one step of a D/A

struct Pulls {
  double worst_error = 0;        ///< N, realised against commanded
  std::array<double, 3> moved{}; ///< m along each axis, under + against under -
};

Pulls pull_each_way(Unit &unit, double force) {
  Pulls pulls;
  for (int axis = 0; axis < 3; ++axis) {
    for (int phase = 0; phase < 2 * kRounds; ++phase) {
      const int sign = phase % 2 == 0 ? 1 : -1;
      const Vector3 wanted = along(axis, sign * force);
      unit.run(kPhase, wanted);
      pulls.worst_error =
          std::max(pulls.worst_error, (unit.state().realised.force - wanted).norm());
      pulls.moved[static_cast<std::size_t>(axis)] +=
          sign * unit.state().pose.position[axis] / kRounds;
    }
    unit.run(kPhase, Vector3::Zero());
  }
  return pulls;
}

Finding grip_goes_along(const Pulls &pulls) {
  constexpr const char *kPromise = "the grip goes where the force points";
  const auto &moved = pulls.moved;
  const std::string figure = formatted("x %+.2f mm, y %+.2f mm, z %+.2f mm between both directions",
                                       moved[0] * 1e3, moved[1] * 1e3, moved[2] * 1e3);
  for (const double way : moved)
    if (way < -kSeen)
      return {kPromise, Verdict::fail, figure + ". " + messages::kCheckOtherWay};
  for (const double way : moved)
    if (way < kSeen)
      return {kPromise, Verdict::not_testable, figure + ": too little to see"};
  return {kPromise, Verdict::pass, figure};
}

Finding tensions_are_limited(const Unit &unit) {
  const spidar::Geometry &geometry = unit.geometry();
  const Record &record = unit.record();
  const bool holds = unit.lowest_tension() >= geometry.tension_min - kOneWord &&
                     unit.highest_tension() <= geometry.tension_max + kOneWord &&
                     record.largest_word <= geometry.dac_limit;
  return verdict("the tension of each string is within the limits of the geometry", holds,
                 formatted("%.2f to %.2f N of %.2f to %.2f N, D/A words up to %d of %d",
                           unit.lowest_tension(), unit.highest_tension(), geometry.tension_min,
                           geometry.tension_max, record.largest_word, geometry.dac_limit),
                 messages::kCheckDefect);
}

Finding not_a_number_is_zero(Unit &unit, double force) {
  unit.run(kPhase, along(0, force));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  unit.command({Vector3(nan, force, 0), Vector3::Zero()});
  unit.exchange();
  const spidar::Tensions under_nan = unit.state().tensions;
  unit.command({});
  unit.exchange();
  const double difference = (unit.state().tensions - under_nan).cwiseAbs().maxCoeff();
  unit.run(kPhase, Vector3::Zero());
  return verdict("a number that is not finite counts as zero", difference <= kOneWord,
                 formatted("tensions differ by %.3f N from those of no force", difference),
                 messages::kCheckDefect);
}

/// Largest change of a counter.
int change(const spidar::Counts &from, const spidar::Counts &to) {
  int largest = 0;
  for (std::size_t i = 0; i < spidar::kStrings; ++i)
    largest = std::max(largest, std::abs(to[i] - from[i]));
  return largest;
}

// ---- The guardian

constexpr const char *kHangs = "the program hangs or is stopped under a force";
constexpr const char *kInStep = "a reply belongs to the exchange that asked for it";
constexpr const char *kGuardianHangs = "the guardian hangs, or takes no more commands";
constexpr const char *kGuardianDies = "the guardian is killed";
constexpr const char *kNotOurs = "there is no guardian that this program may signal: it is a user "
                                 "service, or the device needs none";
constexpr const char *kNoForce =
    "this machine is too late to keep a force: the guardian intervenes before";

/// The guardian lets the grip move during a pause. The first reply after it must show that, not the
/// second one.
Finding replies_are_in_step(Unit &unit, const spidar::Counts &before) {
  constexpr int kVisible = 3; // counts
  const bool first_answered = unit.exchange();
  const spidar::Counts first = unit.state().counts;
  const bool second_answered = unit.exchange();
  const int at_once = change(before, first);
  const int later = change(first, unit.state().counts);
  const std::string figure =
      formatted("after a pause, %d counts at once and %d one reply later", at_once, later);
  if (!first_answered || !second_answered)
    return {kInStep, Verdict::not_testable, "an exchange after the pause was not answered"};
  if (std::max(at_once, later) < kVisible)
    return {kInStep, Verdict::not_testable, figure + ": the grip did not move meanwhile"};
  return verdict(kInStep, at_once > later, figure, messages::kCheckDefect);
}

/// Ticks under `wanted` until `done`, for a second at most. Returns the time, or nothing.
std::optional<Clock::duration> time_until(Unit &unit, const Vector3 &wanted,
                                          const std::function<bool()> &done) {
  constexpr auto kLongest = 1s;
  const auto begin = unit.now();
  unit.forget_gaps();
  while (unit.now() - begin < kLongest) {
    unit.tick(wanted);
    if (done())
      return unit.now() - begin;
  }
  return std::nullopt;
}

} // namespace

double milliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

Finding verdict(const char *promise, bool holds, const std::string &figure, const char *failure) {
  if (holds)
    return {promise, Verdict::pass, figure};
  return {promise, Verdict::fail, figure + ". " + failure};
}

Finding in_time(const char *promise, Clock::duration taken, Clock::duration most,
                Clock::duration mean_exchange, Clock::duration gap) {
  const std::string figure =
      formatted("after %.1f ms, %.0f ms promised", milliseconds(taken), milliseconds(most));
  if (taken <= most)
    return {promise, Verdict::pass, figure};
  if (mean_exchange >= 1ms)
    return {promise, Verdict::not_testable,
            figure + formatted("; not judged, since an exchange takes %.1f ms here",
                               milliseconds(mean_exchange))};
  if (gap > 5ms)
    return {promise, Verdict::not_testable,
            figure + formatted("; this program itself was %.1f ms late", milliseconds(gap))};
  return verdict(promise, false, figure, messages::kCheckLate);
}

bool check_answers(Unit &unit, const Report &report) {
  constexpr double kTime = 0.5; // s
  constexpr int kFault = 3;     // failures in a row
  constexpr int kHopeless = 50; // the same
  const Record before = unit.record();
  const long valid_before = unit.valid_ticks();
  const Record &record = unit.record();
  const auto end = unit.now() + std::chrono::duration<double>(kTime);
  while (unit.now() < end && record.failed_in_a_row < kHopeless)
    unit.run(1e-3, Vector3::Zero());
  const long ticks = record.exchanges - before.exchanges;
  const long failed = record.failed - before.failed;
  const long valid = unit.valid_ticks() - valid_before;
  const bool answers = record.most_failed_in_a_row < kFault && ticks > failed;
  const bool known = valid * 10 >= ticks * 9;
  report(
      verdict("the device answers", answers,
              formatted("%ld of %ld exchanges, %.2f ms on average, %.2f ms at most", ticks - failed,
                        ticks, milliseconds(record.mean()), milliseconds(record.longest)),
              messages::kToolSilent));
  report(verdict("the pose is known", known, formatted("in %ld of %ld exchanges", valid, ticks),
                 messages::kCheckPose));
  return answers && known;
}

void check_hand(Unit &unit, const Ask &ask, const Report &report) {
  constexpr const char *kPromises[] = {"the pose follows the hand to the right (x)",
                                       "the pose follows the hand up (y)",
                                       "the pose follows the hand towards you (z)"};
  constexpr const char *kWays[] = {"to the right", "up", "towards you"};
  for (int axis = 0; axis < 3; ++axis) {
    if (!ask(formatted("Press Enter, then move the grip 2 cm %s.", kWays[axis]))) {
      report({kPromises[axis], Verdict::not_testable, "nobody moved it"});
      continue;
    }
    double moved = 0;
    const int direction = direction_moved(unit, axis, moved);
    const std::string figure = formatted("%s %+.1f mm", kAxes[axis], moved * 1e3);
    if (direction == 0)
      report({kPromises[axis], Verdict::not_testable, figure + ": no movement was seen"});
    else
      report(verdict(kPromises[axis], direction > 0, figure, messages::kCheckOtherWay));
  }
}

void check_force(Unit &unit, double force, const Report &report) {
  const int before = unit.interruptions();
  const Pulls pulls = pull_each_way(unit, force);
  if (unit.let_go() || unit.interruptions() > before) {
    const char *why = unit.let_go() ? "the grip was faster than 1 m/s, so the force went off"
                                    : "the guardian intervened: this machine was late";
    report({"the force is the commanded one", Verdict::not_testable, why});
  } else {
    report(verdict(
        "the force is the commanded one", pulls.worst_error <= kWrongBy + force / 10,
        formatted("%.2f N along each axis, off by %.3f N at most", force, pulls.worst_error),
        messages::kCheckForceOff));
    report(grip_goes_along(pulls));
  }
  report(not_a_number_is_zero(unit, force));
  report(tensions_are_limited(unit));
}

void check_hang(Unit &unit, double force, const Report &report) {
  const auto exchange = spidar::usb_exchange_timeout(); // during it the guardian hears nothing
  const auto promised = exchange + 13ms;
  const auto long_enough = exchange + 98ms;
  const Clock::duration pauses[] = {exchange + 12ms, long_enough}; // the first is just in time
  std::optional<Clock::duration> rested;
  Clock::duration late{};
  Finding in_step{};
  for (const auto pause : pauses) {
    unit.run(kPhase, along(0, force));
    if (unit.force() < force / 2)
      return report({kHangs, Verdict::not_testable, kNoForce});
    const int before = unit.interruptions();
    const spidar::Counts counts = unit.state().counts;
    const auto paused = unit.pause(pause);
    in_step = replies_are_in_step(unit, counts);
    if (unit.interruptions() > before && !rested) {
      rested = paused;
      late = paused - pause;
    }
  }
  unit.run(kPhase, Vector3::Zero());
  if (rested)
    report(in_time(kHangs, *rested, promised, unit.record().mean(), late));
  else
    report(verdict(kHangs, false,
                   formatted("the guardian did nothing for %.0f ms", milliseconds(long_enough)),
                   messages::kCheckGuardian));
  report(in_step);
}

void check_guardian_hangs(Unit &unit, double force, const SignalGuardian &signal,
                          const Report &report) {
  constexpr auto kPromised = 10ms;
  const Vector3 wanted = along(0, force);
  unit.run(kPhase, wanted);
  const int before = unit.interruptions();
  if (unit.force() < force / 2)
    return report({kGuardianHangs, Verdict::not_testable, kNoForce});
  if (!signal(SIGSTOP))
    return report({kGuardianHangs, Verdict::not_testable, kNotOurs});
  const auto noticed = time_until(unit, wanted, [&] { return unit.interruptions() > before; });
  const auto gap = unit.longest_gap();
  signal(SIGCONT);
  const auto back = time_until(unit, Vector3::Zero(), [&] { return !unit.state().interrupted; });
  if (!noticed)
    report(verdict(kGuardianHangs, false, "the force went on for 1 s", messages::kCheckDefect));
  else if (!back)
    report(verdict(kGuardianHangs, false, "it went on, but the force did not return",
                   messages::kCheckDefect));
  else
    report(in_time(kGuardianHangs, *noticed, kPromised, unit.record().mean(), gap));
}

void check_guardian_dies(Unit &unit, double force, const SignalGuardian &signal,
                         const Report &report) {
  constexpr auto kPromised = 10ms;
  const Vector3 wanted = along(0, force);
  unit.run(kPhase, wanted);
  if (!signal(SIGKILL))
    return report({kGuardianDies, Verdict::not_testable, kNotOurs});
  const auto noticed = time_until(unit, wanted, [&] { return !unit.connected(); });
  if (noticed)
    report(in_time(kGuardianDies, *noticed, kPromised, unit.record().mean(), unit.longest_gap()));
  else
    report(verdict(kGuardianDies, false, "the force went on for 1 s", messages::kCheckDefect));
}

void check_unplug(Unit &unit, const Ask &ask, const Report &report) {
  constexpr const char *kPromise = "the USB cable is pulled";
  constexpr auto kPromised = 10ms;
  constexpr int kTimeToPull = 30'000; // ticks
  if (!ask("Press Enter, then pull the USB cable.")) {
    report({kPromise, Verdict::not_testable, "nobody pulled it"});
    return;
  }
  unit.forget_gaps();
  for (int tick = 0; tick < kTimeToPull && unit.connected(); ++tick)
    unit.tick(Vector3::Zero());
  const auto silent = unit.now() - unit.record().answered;
  if (!unit.connected())
    report(in_time(kPromise, silent, kPromised, unit.record().mean(), unit.longest_gap()));
  else if (unit.record().last_answered)
    report({kPromise, Verdict::not_testable, "every exchange was answered"});
  else
    report(verdict(kPromise, false, formatted("not noticed for %.0f ms", milliseconds(silent)),
                   messages::kCheckDefect));
}

void check_close(const Record &record, const Report &report) {
  constexpr const char *kPromise = "closing the device leaves minimum tension";
  if (record.last != record.rest)
    report(verdict(kPromise, false, "the last words were others", messages::kCheckDefect));
  else if (!record.last_answered)
    report({kPromise, Verdict::not_testable,
            "the last exchange was not answered; its guardian repeats it"});
  else
    report({kPromise, Verdict::pass, "the last exchange was answered"});
}

} // namespace spidar_check
