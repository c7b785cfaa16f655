#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Feel a video file at half, normal and double speed: slow motion feels softer, fast motion stronger.
#
# Usage: pipelines/playback-speed.sh [--speed SPEED] FILE [-- OPTION=VALUE...]
#   FILE           a video file or URL
#   --speed SPEED  only at this speed, as a multiple of the normal one (default: 0.5, 1 and 2, one after the other)
#   What follows -- goes to hapticsink. Ctrl-C stops.
#
# Example:
#   pipelines/playback-speed.sh --speed 0.5 in.mp4 -- device=sim
#
# videorate writes new time stamps: hapticsink cannot distinguish slow motion from a slow scene. An
# application that seeks with a rate can choose (rate-law).
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! videorate rate=SPEED ! video/x-raw,framerate=FRAME-RATE-TIMES-SPEED \
#       ! roitracker ! velocityavg ! hapticsink

source "$(dirname "$0")/shared/common.sh"

speeds=(0.5 1 2)
if [ "${1:-}" = --speed ]; then
  if [[ ! ${2:-} =~ ^[0-9]*\.?[0-9]+$ ]] || ! awk -v "speed=$2" 'BEGIN { exit !(speed >= 0.01 && speed <= 100) }'; then
    fail "the speed is a number from 0.01 to 100, for example --speed 0.5; see --help"
  fi
  speeds=("$2")
  shift 2
fi
read_arguments "$@"
need_video "$input"

trap exit INT # instead of the next speed

# The new frame rate shows each frame once: repeated frames would make a uniform motion uneven. 100100 has the usual
# rates without a remainder, and keeps the numerator below 2^31.
rate=${film_rate:-30/1}
for speed in "${speeds[@]}"; do
  echo "at $speed times normal speed"
  played=$(awk -v "rate=$rate" -v "speed=$speed" \
    'BEGIN { split(rate, f, "/"); printf "%d/100100", f[1] / f[2] * speed * 100100 + 0.5 }')
  (launch "${film[@]}" ! videorate "rate=$speed" ! "video/x-raw,framerate=$played" \
    ! roitracker ! velocityavg ! hapticsink "${sink_options[@]}")
done
