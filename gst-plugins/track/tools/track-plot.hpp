// SPDX-License-Identifier: LGPL-2.1-or-later
// Pictures of tracks, drawn by gnuplot.
#pragma once

#include "track-file.hpp"

#include <string>

namespace haptic {

/// Draws a track as .png. Of points: velocity, force and confidence over time. Of fields: arrows
/// over frames of the video at `path`, or over grey, and the amount of motion over time; as .gif
/// the seconds with the most motion. Throws TrackFileError.
void plot_track(const std::string &path, const TrackFile &track, const std::string &output);

} // namespace haptic
