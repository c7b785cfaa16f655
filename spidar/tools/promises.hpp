// SPDX-License-Identifier: LGPL-2.1-or-later
// The promises of docs/safety.md that a program can check on a unit.
#pragma once

#include "checked-unit.hpp"

#include <functional>

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

/// Without a force: the device answers, and knows its pose.
void check_answers(Unit &unit, const Report &report);
/// The pose goes where the person moves the grip.
void check_hand(Unit &unit, const Ask &ask, const Report &report);
/// With `force` (N) along each axis: where it points, what the tensions are, NaN, replies in step.
void check_force(Unit &unit, double force, const Report &report);
/// The device notices that its cable was pulled.
void check_unplug(Unit &unit, const Ask &ask, const Report &report);
/// After the unit was closed.
void check_close(const Record &record, const Report &report);
/// The guardian lets go when the program that drives is killed, or stopped. No device may be open.
/// `ask` may be empty.
void check_guardian(const spidar_tools::Choice &choice, double force, const Ask &ask,
                    const Report &report);

} // namespace spidar_check
