// SPDX-License-Identifier: LGPL-2.1-or-later
// From what a person sees and measures to a geometry file.
#pragma once

#include "spidar/export.hpp"
#include "spidar/geometry.hpp"

#include <string>

namespace spidar {

/// Scale of the strings: the grip was moved by `moved` (m) along `axis` (0 x, 1 y, 2 z) from the
/// centre, and the counters moved from `centre` to `there`. Throws Error (argument) when the two
/// do not fit: the hand moved another way, too little to measure, or another unit was meant.
SPIDAR_API Geometry with_measured_counts(Geometry geometry, const Counts &centre,
                                         const Counts &there, int axis, double moved);

/// Scale of the motors: commanded `commanded` (N) along an axis, a spring balance showed
/// `measured` (N). Throws Error (argument) when the two differ by more than a factor of five.
SPIDAR_API Geometry with_measured_force(Geometry geometry, double commanded, double measured);

/// The geometry as if the grip were seen in a mirror across `axis`: what pulled towards the one
/// side pulls towards the other.
SPIDAR_API Geometry mirrored(Geometry geometry, int axis);

/// What load_geometry() reads. Throws Error (geometry) for what it would refuse, before anything is
/// written, and (not_found) for a path that cannot be written.
SPIDAR_API void save_geometry(const Geometry &geometry, const std::string &path);

} // namespace spidar
