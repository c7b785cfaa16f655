// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads logs of hapticsink (docs/formats/csv-log.md), or tables of others with the same columns.
#pragma once

#include "felt/force-signal.hpp"
#include "tracks/hand-path.hpp"

#include <string>
#include <vector>

namespace haptic {

/// Half of the workspace in which a log's positions are meant, m: that of every built-in geometry.
inline constexpr double kWorkspaceHalf = 0.025;

struct ForceLog {
  std::vector<TimedForce> forces; ///< in rising order of time
  std::vector<TimedPlace> places; ///< of the same rows; empty if the log has none
};

/// Returns whether a file begins with the names of columns.
bool is_force_log(const std::string &path);

/// Reads the columns time, fx, fy, and, where they are, fz, x, y and z. Of rows with one time, as
/// while paused, the last one counts. Throws TrackFileError.
ForceLog read_force_log(const std::string &path);

/// Returns the path of the hand in a log, which counts from the first frame of the video, at
/// `begin` s. Throws TrackFileError, also if it has none.
std::vector<TimedPlace> read_hand(const std::string &path, double begin);

} // namespace haptic
