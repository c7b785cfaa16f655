// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether a machine is in time for a force, judged by what was measured on it. SI units.
#pragma once

#include "spidar/device-limits.hpp"
#include "spidar/export.hpp"

#include <optional>
#include <string>
#include <vector>

namespace spidar {

/// How late the ticks of a clock began, s.
struct Lateness {
  double usual = 0; ///< 99.9 % of the ticks were not later
  double worst = 0;
};

/// Each is how late a tick began, s. None: never late.
SPIDAR_API Lateness lateness_of(std::vector<double> ticks);

struct MachineTiming {
  double period = 0.001;            ///< s, between two ticks
  bool priority = false;            ///< the ticks had real-time priority
  Lateness lateness;                ///< while nothing else kept the processors busy
  std::optional<Lateness> loaded;   ///< while all processors were busy, if that was measured
  std::optional<double> round_trip; ///< s, of an exchange with a device; 99.9 % did not take longer
  DeviceLimits device;              ///< nothing is said of a touch if it knows no newtons
};

enum class Fitness { fit, limited, unfit };

struct MachineVerdict {
  Fitness fitness = Fitness::fit;
  std::string text; ///< one sentence, and the cure behind it if there is one
};

/// The gravest of what was measured decides. docs/spidar.md#check-the-machine has the rules.
SPIDAR_API MachineVerdict judge_machine(const MachineTiming &timing);

/// N/m, of a touch of this device at the default slew rate, where the ticks come up to `longest` s
/// apart (docs/force.md#touch).
SPIDAR_API double stiffest_touch(const DeviceLimits &device, double longest) noexcept;

} // namespace spidar
