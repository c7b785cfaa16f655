// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "loop/flight-recorder.hpp"

#include <string>

namespace haptic {

/// Writes what the flight recorder has kept as a CSV log (docs/formats/csv-log.md) into `folder`,
/// which it makes if it has to. Returns a message for the user that names the file, the rule that
/// stopped the force and the late ticks of the last second, or why there is no file; empty if
/// nothing was kept, or if this process has written 20 files. Not for the loop's thread.
std::string write_fault_record(FlightRecorder &recorder, const std::string &folder);

} // namespace haptic
