// SPDX-License-Identifier: LGPL-2.1-or-later
#include "promises.hpp"

#include "fail.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <thread>

namespace spidar_check {

using namespace std::chrono_literals;
using spidar::formatted;
using spidar::Vector3;
namespace messages = spidar::messages;

namespace {

constexpr const char *kAxes[] = {"x", "y", "z"};

double milliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

Finding verdict(const char *promise, bool holds, const std::string &figure, const char *failure) {
  if (holds)
    return {promise, Verdict::pass, figure};
  return {promise, Verdict::fail, figure + ". " + failure};
}

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
  return verdict("tensions stay within the limits of the geometry", holds,
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
  const double difference = (unit.state().tensions - under_nan).cwiseAbs().maxCoeff();
  unit.run(kPhase, Vector3::Zero());
  return verdict("a force that is not a number counts as zero", difference <= kOneWord,
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

/// The guardian lets the grip move during a pause. The first reply after it must show that, not the
/// second one.
Finding replies_are_in_step(Unit &unit, double force) {
  constexpr const char *kPromise = "a reply belongs to the exchange that asked for it";
  constexpr int kVisible = 3; // counts
  unit.run(kPhase, along(0, force));
  const spidar::Counts before = unit.state().counts;
  std::this_thread::sleep_for(100ms);
  const bool first_answered = unit.exchange();
  const spidar::Counts first = unit.state().counts;
  const bool second_answered = unit.exchange();
  const int at_once = change(before, first);
  const int later = change(first, unit.state().counts);
  unit.run(kPhase, Vector3::Zero());
  const std::string figure =
      formatted("after a pause, %d counts at once and %d one reply later", at_once, later);
  if (!first_answered || !second_answered)
    return {kPromise, Verdict::not_testable, "an exchange after the pause was not answered"};
  if (std::max(at_once, later) < kVisible)
    return {kPromise, Verdict::not_testable, figure + ": the grip did not move meanwhile"};
  return verdict(kPromise, at_once > later, figure, messages::kCheckDefect);
}

} // namespace

void check_answers(Unit &unit, const Report &report) {
  constexpr double kTime = 0.5; // s
  constexpr int kFault = 3;     // failures in a row
  const Record before = unit.record();
  const long valid_before = unit.valid_ticks();
  unit.run(kTime, Vector3::Zero());
  const Record &record = unit.record();
  const long ticks = record.exchanges - before.exchanges;
  const long failed = record.failed - before.failed;
  const long valid = unit.valid_ticks() - valid_before;
  report(verdict("the device answers", record.most_failed_in_a_row < kFault,
                 formatted("%ld of %ld exchanges, the longest took %.2f ms", ticks - failed, ticks,
                           milliseconds(record.longest)),
                 messages::kToolSilent));
  report(verdict("the pose is known", valid * 10 >= ticks * 9,
                 formatted("in %ld of %ld exchanges", valid, ticks), messages::kCheckPose));
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
  const Pulls pulls = pull_each_way(unit, force);
  const Finding not_number = not_a_number_is_zero(unit, force);
  const Finding in_step = replies_are_in_step(unit, force);
  if (unit.let_go() || unit.interruptions() > 1) { // one is meant, during the pause
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
  report(not_number);
  report(in_step);
  report(tensions_are_limited(unit));
}

void check_unplug(Unit &unit, const Ask &ask, const Report &report) {
  constexpr const char *kPromise = "a pulled cable is noticed";
  constexpr int kTimeToPull = 30'000; // ticks
  if (!ask("Press Enter, then pull the USB cable.")) {
    report({kPromise, Verdict::not_testable, "nobody pulled it"});
    return;
  }
  for (int tick = 0; tick < kTimeToPull && unit.connected(); ++tick)
    unit.tick(Vector3::Zero());
  if (unit.connected())
    report({kPromise, Verdict::not_testable, "every exchange was answered"});
  else
    report({kPromise, Verdict::pass,
            formatted("%.1f ms after the last answer",
                      milliseconds(Clock::now() - unit.record().answered))});
}

void check_close(const Record &record, const Report &report) {
  report(verdict("closing leaves minimum tension",
                 record.last == record.rest && record.last_answered,
                 record.last_answered ? "the last exchange was answered"
                                      : "the last exchange was not answered",
                 messages::kCheckDefect));
}

} // namespace spidar_check
