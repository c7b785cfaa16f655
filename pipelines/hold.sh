#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Press on something in a video, and hold it: while the button is down, the hand feels the motion of that thing, wherever
# it goes. The window shows a ring about the thing, its path of the last second, and a word if it is not seen.
#
# Usage: pipelines/hold.sh [--grip | --at X,Y] [--law LAW] [FILE] [-- OPTION=VALUE...]
#   FILE    a video file or URL (default: the film of the demonstration)
#   --grip  the device points, and a button of the device presses: --grip -- device=evdev
#   --at    nobody presses. The script holds the thing at X,Y of the first frame, each 0 to 1 from the top left
#   --law   motion (default): the hand feels the motion of the thing; carry: a spring carries the hand along with the
#           thing; both: the two together
#   What follows -- goes to hapticsink, for example log-location=trace.csv. Ctrl-C stops.
#
# Example:
#   pipelines/hold.sh --at 0.3,0.5 in.mp4 -- device=sim
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! roitracker pointer-source=navigation ! tee name=t \
#       t. ! queue max-size-buffers=1 ! videoconvert ! hapticoverlay style=arrows ! autovideosink \
#       t. ! queue max-size-buffers=1 ! velocityavg ! hapticsink device=sim
#
# The mouse presses with its first button, a touch screen with the first finger. The force is that of a simulated device,
# or of the one named after --: press with the mouse, and feel with the other hand.

source "$(dirname "$0")/shared/common.sh"
source "$(dirname "$0")/shared/packages.sh"

at='' grip=no law=motion
read_options 'at= grip law= --' "$@"
[ ${#inputs[@]} -le 1 ] || fail "there is more than one video; give one, and write options of hapticsink after --, see --help"
[ -z "$at" ] || [ $grip = no ] || fail "give either --grip or --at, not both"
fraction='(0|1|0\.[0-9]+|1\.0+)'
[ -z "$at" ] || [[ $at =~ ^$fraction,$fraction$ ]] ||
  fail "--at needs two numbers from 0 to 1, as in 0.3,0.6, not '$at'"
[[ $law =~ ^(motion|carry|both)$ ]] || fail "--law is motion, carry or both, not '$law'"
input=${inputs[0]:-}
default_to_wind_film
need_video "$input"

pointer=(pointer-source=navigation)
[ -z "$at" ] || pointer=(pointer-source=property "pointer-x=${at%,*}" "pointer-y=${at#*,}" pressed=true)
[ $grip = no ] || pointer=(pointer-source=haptic)
file_window videoconvert ! hapticoverlay style=arrows !
if [ $grip = yes ] || [ -n "$at" ]; then
  may_show || file_window_branch=()
else
  need_display
fi

elements=(roitracker velocityavg hapticsink hapticoverlay)
launch "${film[@]}" ! roitracker "${pointer[@]}" ! "${file_window_branch[@]}" velocityavg \
  ! hapticsink device=sim "hold-law=$law" "${sink_options[@]}"
