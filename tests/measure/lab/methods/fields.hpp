// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion of a whole frame on a grid: the project's field and its peers against the true flow.
#pragma once

#include "results/report.hpp"
#include "scenes/pairs.hpp"

namespace lab {

/// Each pair with each method: the field of 32 columns, and dense flow of the whole frames
/// averaged over the same cells.
std::vector<FieldRow> measure_fields(const std::vector<TruePair> &pairs);

} // namespace lab
