// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether a method knows when it is wrong.
#pragma once

#include "methods/methods.hpp"
#include "results/report.hpp"

namespace lab {

/// Fills `reliability`, `roc` and `area` for the methods with a confidence, from every hard scene
/// with five seeds.
void measure_confidence(const std::vector<Configuration> &defaults, bool quick, Report &report);

} // namespace lab
