#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Touch a film that has depth: the hand feels the shape of things, and their motion too. depth-film draws such a film:
# balls that bounce, circle and roll.
#
# Usage: pipelines/touch-depth.sh [OPTION...] [-- OPTION=VALUE...]
#   --video FILE   a video of your own. Its right half is the depth of its left half, in grey: white is near, and
#                  black is unknown
#   --still        shows a photograph of an aloe instead, with its disparity, from the Debian package opencv-doc
#   --touch WHAT   what makes the force. surface+motion (default): both; surface: the shape only; off: the motion only
#   --no-window    opens no window. The window shows height as light, and the picture yields under the hand
#   --output DIR   where the log trace.csv and the plot trace.png go (default: touch-output)
#   What follows -- goes to hapticsink, for example device=usb. Ctrl-C stops.
#
# Example:
#   pipelines/touch-depth.sh --still -- device=sim
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! tee name=sides \
#       sides. ! queue max-size-buffers=1 ! videocrop right=640 \
#         ! roitracker ! velocityavg ! hapticsink name=hand touch=surface+motion log-location=trace.csv \
#       sides. ! queue max-size-buffers=1 ! videocrop left=640 ! videoconvert ! video/x-raw,format=GRAY8 \
#         ! depthfield kind=disparity scale=255 near=1.0625 far=15 ! hand.relief

source "$(dirname "$0")/shared/common.sh"
source "$(dirname "$0")/shared/packages.sh"
source "$(dirname "$0")/shared/touch.sh"

still=no
read_touch_options still "$@"
[ -z "$video" ] || [ "$still" = no ] || fail "give either --video or --still, not both"
use_elements depthfield roitracker velocityavg hapticsink hapticoverlay
need_packaged_elements videocrop multifilesrc jpegdec pngdec
depth=(depthfield kind=disparity scale=255)
hand=circle:0.5,10

if [ "$still" = yes ]; then
  title="Aloe (Middlebury 2006)"
  picture=$(opencv_file aloeL.jpg)
  disparity=$(opencv_file aloeGT.png)
  hand=file:$root/pipelines/films/hands/aloe-hand.csv
else
  [ -n "$video" ] || { video=$(depth_film) && hand=file:$root/pipelines/films/hands/depth-hand.csv; }
  title=${video##*/}
  need_video "$video"
  [[ ${film_width:-none} =~ [02468]$ ]] ||
    fail "the frames of '$video' are ${film_width:-?} px wide and cannot be halved; give a video with depth right of the picture"
fi
make_output "$output"
choose_window
feel "sim-hand=$(quoted "$hand")"

grey=video/x-raw,format=GRAY8
if [ "$still" = yes ]; then
  # imagefreeze would not end by Ctrl-C. The disparity is 43 (far) to 211 (near); 0 where only one of both cameras sees.
  still_of=(multifilesrc loop=true)
  play "$title" "${still_of[@]}" "location=$(quoted "$picture")" caps=image/jpeg,framerate=10/1 ! jpegdec ! videoconvert \
    ! "${felt[@]}" \
    "${still_of[@]}" "location=$(quoted "$disparity")" caps=image/png,framerate=10/1 ! pngdec ! videoconvert ! $grey \
    ! "${depth[@]}" near=1.2 far=6 ! "${to_hand[@]}"
else
  half=$((film_width / 2))
  # The luma of video is 16 (black) to 235, and some more where it was compressed; a full range begins at 0.
  levels=(near=1.0625 far=15)
  [[ $film_colours != 1:* ]] || levels=(near=1 far=255)
  play "$title" "${film[@]}" ! tee name=sides \
    sides. ! queue max-size-buffers=1 ! videocrop "right=$half" ! "${felt[@]}" \
    sides. ! queue max-size-buffers=1 ! videocrop "left=$half" ! videoconvert ! $grey \
    ! "${depth[@]}" "${levels[@]}" ! "${to_hand[@]}"
fi
