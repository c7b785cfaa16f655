// SPDX-License-Identifier: LGPL-2.1-or-later
// JSON as haptic-track writes it.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

namespace haptic {

/// Keeps its keys in the order in which they are written.
using Json = nlohmann::ordered_json;

/// Returns the nearest multiple of 1 / `units`, which has few digits.
inline double rounded(double value, double units) {
  return std::round(value * units) / units;
}

} // namespace haptic
