// SPDX-License-Identifier: LGPL-2.1-or-later
// Finds the directions in which strings cannot pull, by non-negative least squares.
#pragma once

#include "model/string-kinematics.hpp"

#include <string>

namespace spidar {

/// Directions that no non-negative combination of the columns of `pull` gives, in words; empty if
/// the columns span all six dimensions positively. Torque rows in units of the grip radius.
std::string directions_out_of_reach(const WrenchMatrix &pull);

} // namespace spidar
