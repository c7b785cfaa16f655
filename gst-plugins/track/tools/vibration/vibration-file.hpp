// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes what a hand would feel from a track as vibration: sound for actuators, or a pattern for
// telephones.
#pragma once

#include "samples/force-defaults.hpp"
#include "tracks/track-file.hpp"

#include <string>

namespace haptic {

/// The options of hapticarray.
struct VibrationOptions {
  std::string layout = "back-3x4"; ///< name or path, as hapticarray reads it
  std::string map = "stroke";      ///< one of the words of hapticarray's map
  double alpha = kDefaultAlpha;    ///< s/px
};

/// Returns whether the ending is .wav or .ahap.
bool is_vibration_file(const std::string &path);

/// Writes a file with one of these endings. It appears under its name when it is whole. Throws
/// TrackFileError.
void write_vibration_file(const std::string &path, const TrackFile &track,
                          const VibrationOptions &options);

} // namespace haptic
