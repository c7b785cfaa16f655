// SPDX-License-Identifier: LGPL-2.1-or-later
// What each part of the default costs and saves.
#pragma once

#include "results/report.hpp"
#include "scenes/pairs.hpp"

namespace lab {

/// The default against itself without each of its parts, in turns on the same frames: streams of
/// rendered scenes, and the pairs.
std::vector<AblationRow> measure_ablation(bool quick, const std::vector<TruePair> &pairs);

} // namespace lab
