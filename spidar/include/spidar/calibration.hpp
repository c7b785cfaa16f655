// SPDX-License-Identifier: LGPL-2.1-or-later
// Corrects a geometry by what a person has measured on the device, and writes it to a file.
// Lengths in m, forces in N, in the workspace frame of types.hpp. Not for the real-time thread.
#pragma once

#include "spidar/export.hpp"
#include "spidar/geometry.hpp"

#include <string>

namespace spidar {

/// Scales the metres per count: the grip was moved by `moved` (m) along `axis` (0 x, 1 y, 2 z) from
/// the centre, and the counters went from `centre` to `there`. Throws Error (argument) if the two
/// contradict each other: another direction, too short a way, or another unit.
SPIDAR_API Geometry with_measured_counts(Geometry geometry, const Counts &centre,
                                         const Counts &there, int axis, double moved);

/// Scales the volts per newton: a spring balance showed `measured` (N) under the command of
/// `commanded` (N). Throws Error (argument) if they differ by more than a factor of five.
SPIDAR_API Geometry with_measured_force(Geometry geometry, double commanded, double measured);

/// Reverses the direction of `axis` (0 x, 1 y, 2 z).
SPIDAR_API Geometry mirrored(Geometry geometry, int axis);

/// Writes a file for load_geometry(). Throws Error: geometry if load_geometry() would refuse it,
/// and then writes nothing; not_found if `path` cannot be written.
SPIDAR_API void save_geometry(const Geometry &geometry, const std::string &path);

} // namespace spidar
