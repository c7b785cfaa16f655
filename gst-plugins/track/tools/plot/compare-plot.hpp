// SPDX-License-Identifier: LGPL-2.1-or-later
// The picture of a comparison, drawn by gnuplot.
#pragma once

#include "felt/perception.hpp"

#include <cstddef>
#include <string>

namespace haptic {

/// Draws as .png both forces at one place, at the shift at which they fit best, and over time the
/// share of all places at which a hand can tell them apart. `caption` must be safe between single
/// quotes in gnuplot. Throws TrackFileError.
void plot_comparison(const Comparison &result, const SignalsAt &signals_at, std::size_t place,
                     const std::string &caption, bool is_touch, const std::string &output);

} // namespace haptic
