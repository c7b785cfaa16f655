// SPDX-License-Identifier: LGPL-2.1-or-later
// The promises of docs/safety.md that a program can check on a unit.
#pragma once

#include "checked-unit.hpp"

#include <functional>
#include <string>

namespace spidar_check {

enum class Verdict { pass, fail, not_testable };

struct Finding {
  const char *promise;
  Verdict verdict;
  std::string figure; ///< what was measured, or why nothing was; the cure of a failure
};

using Report = std::function<void(const Finding &)>;
/// Asks the person to do something. False if the answer is "n", or there is nobody.
using Ask = std::function<bool(const std::string &)>;
/// Sends a signal to the guardian of the open device. False if it is not this program's to signal.
using SignalGuardian = std::function<bool(int)>;

Finding verdict(const char *promise, bool holds, const std::string &figure, const char *failure);
double milliseconds(Clock::duration time);
/// Judges `taken` by `most`. More is not testable where a mean exchange takes 1 ms or more, or
/// where the program itself was late (`gap`: its longest time between two exchanges).
Finding in_time(const char *promise, Clock::duration taken, Clock::duration most,
                Clock::duration mean_exchange, Clock::duration gap);

/// Without a force: the device answers, and knows its pose. False if it does not; it must not pull
/// then.
bool check_answers(Unit &unit, const Report &report);
/// The pose goes where the person moves the grip.
void check_hand(Unit &unit, const Ask &ask, const Report &report);
/// With `force` (N) along each axis: where it points, what the tensions are, NaN.
void check_force(Unit &unit, double force, const Report &report);
/// The program hangs under `force` (N): the guardian sets minimum tension, and replies stay in
/// step.
void check_hang(Unit &unit, double force, const Report &report);
/// The guardian is stopped under `force` (N), and goes on.
void check_guardian_hangs(Unit &unit, double force, const SignalGuardian &signal,
                          const Report &report);
/// The guardian is killed under `force` (N). The unit is of no use afterwards.
void check_guardian_dies(Unit &unit, double force, const SignalGuardian &signal,
                         const Report &report);
/// The device notices that its cable was pulled.
void check_unplug(Unit &unit, const Ask &ask, const Report &report);
/// After the unit was closed.
void check_close(const Record &record, const Report &report);

} // namespace spidar_check
