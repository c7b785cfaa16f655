#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Feel a video file: the three elements in a row, without a window.
#
# Usage: pipelines/play-file.sh FILE [-- OPTION=VALUE...]
#   FILE  a video file or URL
#   What follows -- goes to hapticsink. Ctrl-C stops.
#
# Example:
#   pipelines/play-file.sh in.mp4 -- device=sim sim-hand=circle:0.5,10 log-location=trace.csv
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! roitracker ! velocityavg ! hapticsink

source "$(dirname "$0")/shared/common.sh"

read_arguments "$@"
need_video "$input"

launch "${film[@]}" ! roitracker ! velocityavg ! hapticsink "${sink_options[@]}"
