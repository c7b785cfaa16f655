// SPDX-License-Identifier: LGPL-2.1-or-later
// Frames of tracks, drawn by gnuplot.
#pragma once

#include "track-file.hpp"

#include <string>

namespace haptic {

/// Of points: velocity, force and confidence over time, as .png. Of fields: arrows over frames of
/// the video beside them, or over grey, and how much moves over time, as .png; the liveliest
/// seconds of it as a moving .gif. `path` is where the track was read. Throws TrackFileError.
void plot_track(const std::string &path, const TrackFile &track, const std::string &output);

} // namespace haptic
