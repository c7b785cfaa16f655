// Motion of a whole picture on a grid: the project's field and its peers against the true flow.
#pragma once

#include "pairs.hpp"
#include "report.hpp"

namespace lab {

/// Each pair with each method: the field of 32 columns, and dense flow of the whole pictures
/// averaged over the same cells.
std::vector<FieldRow> measure_fields(const std::vector<TruePair> &pairs);

} // namespace lab
