#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The mouse replaces the device: it points over the video window, and hapticsink computes the force
# that a hand would feel. By default the force goes to the log only.
#
# Usage: pipelines/mouse.sh [FILE] [-- OPTION=VALUE...]
#   FILE  a video file or URL (default: the film of the demonstration)
#   What follows -- goes to hapticsink. With device=usb you point with the mouse and feel with the other hand.
#   Ctrl-C stops.
#
# Example:
#   pipelines/mouse.sh in.mp4 -- log-location=trace.csv
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! roitracker pointer-source=navigation ! tee name=t \
#       t. ! queue max-size-buffers=1 ! videoconvert ! autovideosink \
#       t. ! queue max-size-buffers=1 ! velocityavg ! hapticsink device=none log-location=trace.csv
#
# X11 windows report the mouse 20 times a second; glimagesink, where it is installed, reports at once.

source "$(dirname "$0")/shared/common.sh"
source "$(dirname "$0")/shared/packages.sh"

read_arguments "$@"
default_to_wind_film
need_video "$input"
need_display

launch "${film[@]}" ! roitracker pointer-source=navigation ! "${file_window_branch[@]}" velocityavg \
  ! hapticsink device=none "${sink_options[@]}"
