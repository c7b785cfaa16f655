#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Feel what a camera sees, with a window beside it where there is a display.
#
#   gst-launch-1.0 v4l2src device=/dev/video0 ! video/x-raw,framerate=30/1 \
#       ! queue leaky=downstream max-size-buffers=1 ! videoconvert ! roitracker ! tee name=t \
#       t. ! queue ! videoconvert ! hapticoverlay ! autovideosink \
#       t. ! queue ! velocityavg ! hapticsink
#
# The source is live, so hapticsink gives each sample to the hand at once instead of waiting for the
# window.
#
# Usage: pipelines/camera.sh [DEVICE | --test-source] [-- OPTION=VALUE...]
#   DEVICE         the camera, /dev/video0 if none is given
#   --test-source  a live test picture that moves to the left at 60 px/s, instead of a camera
#   What follows -- goes to hapticsink. Ctrl-C stops.

source "$(dirname "$0")/common.sh"

if [ "${1:-}" = --test-source ]; then
  shift
  read_arguments "$@"
  source=(videotestsrc is-live=true pattern=checkers-8 horizontal-speed=2
    ! "video/x-raw,width=352,height=288,framerate=30/1")
else
  read_arguments "$@"
  need_camera "${input:=/dev/video0}"
  source=(v4l2src "device=$input")
fi
if ! has_display; then
  echo "There is no display: going on without a window."
  window_branch=()
fi

launch "${source[@]}" ! "${camera_pictures[@]}" \
  ! roitracker ! "${window_branch[@]}" velocityavg ! hapticsink "${sink_options[@]}"
