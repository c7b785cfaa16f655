#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Feel the video of a camera, with a window where there is a display.
#
# Usage: pipelines/camera.sh [DEVICE | --test-source] [-- OPTION=VALUE...]
#   DEVICE         the camera (default: /dev/video0)
#   --test-source  a live test video that moves to the left at 60 px/s
#   What follows -- goes to hapticsink. Ctrl-C stops.
#
# Example:
#   pipelines/camera.sh /dev/video2 -- device=sim
#
# The line that it runs:
#
#   gst-launch-1.0 v4l2src device=/dev/video0 ! video/x-raw,framerate=30/1 \
#       ! queue leaky=downstream max-size-buffers=1 ! videoconvert ! roitracker ! tee name=t \
#       t. ! queue ! videoconvert ! hapticoverlay ! autovideosink \
#       t. ! queue ! velocityavg ! hapticsink
#
# The source is live: hapticsink plays each sample at once instead of waiting for the window.

source "$(dirname "$0")/shared/common.sh"

if [ "${1:-}" = --test-source ]; then
  shift
  read_arguments "$@"
  source=("${test_source[@]}")
else
  read_arguments "$@"
  need_camera "${input:=/dev/video0}"
  source=(v4l2src "device=$input")
fi
may_show || window_branch=()

launch "${source[@]}" ! "${camera_frames[@]}" \
  ! roitracker ! "${window_branch[@]}" velocityavg ! hapticsink "${sink_options[@]}"
