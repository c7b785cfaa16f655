// SPDX-License-Identifier: LGPL-2.1-or-later
// Pictures of tracks, drawn by gnuplot.
#pragma once

#include "tracks/hand-path.hpp"
#include "tracks/track-file.hpp"

#include <string>
#include <vector>

namespace haptic {

/// Where the surface of reliefs is drawn.
struct PlotOptions {
  double x = 0.5; ///< 0..1, share of the frame from its top left
  double y = 0.5;
  std::vector<TimedPlace> hand; ///< instead of x and y, if not empty
};

/// Draws a track as .png. Of points: velocity, force and confidence over time. Of fields: arrows
/// over frames of the video at `path`, or over grey, and the amount of motion over time; as .gif
/// the seconds with the most motion. Of reliefs: height and stiffness over time. Throws
/// TrackFileError.
void plot_track(const std::string &path, const TrackFile &track, const PlotOptions &options,
                const std::string &output);

} // namespace haptic
