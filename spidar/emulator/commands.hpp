// SPDX-License-Identifier: LGPL-2.1-or-later
// Executes faults given as lines of text: `COMMAND [VALUE...] [@UNIT]`. One thread.
#pragma once

#include "unit.hpp"

#include <memory>

namespace emulator {

/// Text for users: the commands, one a line.
extern const char *const kCommandHelp;

/// Executes `line` for one unit or, without @UNIT, for all. An empty line does nothing. Appends the
/// transfers that end to `done`, at the unit's number less 1. Throws spidar::Error (argument) for a
/// line that it does not know, and then has done nothing.
void obey(const std::string &line, const std::vector<std::unique_ptr<Unit>> &units, Time now,
          std::vector<std::vector<Completion>> &done);

} // namespace emulator
