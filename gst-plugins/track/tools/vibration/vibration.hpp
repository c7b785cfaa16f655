// SPDX-License-Identifier: LGPL-2.1-or-later
// How haptic-track makes a vibration of a track: the options of hapticarray.
#pragma once

#include "samples/force-defaults.hpp"

#include <gst/gst.h>
#include <string>

namespace haptic {

/// Of .wav and .ahap.
struct VibrationOptions {
  std::string layout = "back-3x4"; ///< name or path, as hapticarray reads it
  std::string map = "stroke";      ///< one of the words of hapticarray's map
  double alpha = kDefaultAlpha;    ///< s/px
};

/// Sets the properties of a hapticarray. `has_fields`: the track holds fields, which map=field
/// needs. Throws TrackFileError.
void set_vibration(GstElement *array, const VibrationOptions &options, bool has_fields);

} // namespace haptic
