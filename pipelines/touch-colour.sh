#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Touch what has colour: a table says how high, hard and rough each colour is, and the hand feels that and the motion.
#
# Usage: pipelines/touch-colour.sh [OPTION...] [-- OPTION=VALUE...]
#   --video FILE   any video (default: the film of the demonstration)
#   --table TABLE  generic, fabric, foliage, or a file of your own (default: generic, and foliage for the film of
#                  the demonstration)
#   --touch WHAT   what makes the force. surface+motion (default): both; surface: the surface only; off: the motion
#                  only
#   --no-window    opens no window. The window shows height as light, and the picture yields under the hand
#   --output DIR   where the log trace.csv and the plot trace.png go (default: touch-output)
#   What follows -- goes to hapticsink, for example device=usb. Ctrl-C stops.
#
# Example:
#   pipelines/touch-colour.sh --video in.mp4 --table fabric -- device=sim
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! tee name=colours \
#       colours. ! queue max-size-buffers=1 \
#         ! roitracker ! velocityavg ! hapticsink name=hand touch=surface+motion log-location=trace.csv \
#       colours. ! queue max-size-buffers=1 ! videoconvert ! reliefmap table=generic ! hand.relief

source "$(dirname "$0")/shared/common.sh"
source "$(dirname "$0")/shared/packages.sh"
source "$(dirname "$0")/shared/touch.sh"

# Fails if reliefmap does not take the table.
need_table() {
  local log
  log=$(gst-launch-1.0 videotestsrc num-buffers=1 ! videoconvert ! reliefmap "table=$(quoted "$table")" ! fakesink 2>&1) ||
    fail "$(reason <<<"$log")"
}

table=''
read_touch_options table= "$@"
use_elements reliefmap roitracker velocityavg hapticsink hapticoverlay
[ -z "$table" ] || need_table
hand=circle:0.5,10 strength=()
if [ -z "$video" ]; then
  video=$(wind_film)
  hand=file:$root/pipelines/films/hands/wind-hand.csv strength=("alpha=$wind_alpha")
  table=${table:-foliage}
fi
need_video "$video"
make_output "$output"
choose_window
feel "sim-hand=$(quoted "$hand")" "${strength[@]}"

play "${video##*/}" "${film[@]}" ! tee name=colours \
  colours. ! queue max-size-buffers=1 ! "${felt[@]}" \
  colours. ! queue max-size-buffers=1 ! videoconvert ! reliefmap "table=$(quoted "${table:-generic}")" ! "${to_hand[@]}"
