// SPDX-License-Identifier: LGPL-2.1-or-later
// Faults as lines of text: `COMMAND [VALUE...] [@UNIT]`.
#pragma once

#include "unit.hpp"

#include <memory>

namespace emulator {

/// What is accepted, a line each, for people.
extern const char *const kCommandHelp;

/// Does what `line` says to one unit or, without @UNIT, to all. Empty lines do nothing. Transfers
/// that this ends go to `done`, by the unit's number less 1. Throws spidar::Error (argument) and
/// then has done nothing.
void obey(const std::string &line, const std::vector<std::unique_ptr<Unit>> &units, Time now,
          std::vector<std::vector<Completion>> &done);

} // namespace emulator
