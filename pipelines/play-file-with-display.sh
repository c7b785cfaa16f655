#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Feel a video file and see it in a window.
#
# Usage: pipelines/play-file-with-display.sh FILE [-- OPTION=VALUE...]
#   FILE  a video file or URL
#   What follows -- goes to hapticsink. Ctrl-C stops.
#
# Example:
#   pipelines/play-file-with-display.sh in.mp4 -- device=sim
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! roitracker ! tee name=t \
#       t. ! queue max-size-buffers=1 ! videoconvert ! autovideosink \
#       t. ! queue max-size-buffers=1 ! velocityavg ! hapticsink

source "$(dirname "$0")/shared/common.sh"

read_arguments "$@"
need_video "$input"
need_display

launch "${film[@]}" ! roitracker ! "${file_window_branch[@]}" velocityavg ! hapticsink "${sink_options[@]}"
