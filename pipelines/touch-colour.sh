#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Touch what has colour: a table says how high, hard and rough each colour is, and the hand feels that and the motion.
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! tee name=colours \
#       colours. ! queue max-size-buffers=1 \
#         ! roitracker ! velocityavg ! hapticsink name=hand touch=surface+motion log-location=trace.csv \
#       colours. ! queue max-size-buffers=1 ! videoconvert ! reliefmap table=generic ! hand.relief
#
# Usage: pipelines/touch-colour.sh [OPTION...] [-- OPTION=VALUE...]
#   --video FILE   any video (default: the film of the demonstration)
#   --table TABLE  generic, fabric, foliage, or a file of your own (default: generic; foliage for the film of the
#                  demonstration)
#   --touch WHAT   surface+motion (default): force of the surface and of the motion; surface: of the surface; off: of the
#                  motion
#   --no-window    also where there is a display; the window shows height as light, and yields under the hand
#   --output DIR   where the log trace.csv and its plot trace.png go (touch-output)
#   What follows -- goes to hapticsink, for example device=usb. Ctrl-C stops.

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
