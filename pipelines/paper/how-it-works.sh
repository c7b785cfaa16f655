#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws the four pictures of docs/how-it-works.md from two seconds of the film of the demonstration.
#
#   point.webp    the frame and the square under the hand
#   measure.webp  the square, enlarged three times: what each small patch did, and the velocity that explains it
#   law.svg       equation 5, with one worked number
#   time.svg      one velocity for each frame, one force for each millisecond
#
# Usage: pipelines/paper/how-it-works.sh FOLDER
#   FOLDER  where the pictures go, for example docs/images/how

source "$(dirname "$0")/film-pictures.sh"

# `cut FILE WIDTH HEIGHT X Y TIMES SECONDS` cuts a part of the frames from 9 s on, and enlarges it.
cut() {
  ffmpeg -v fatal -y -ss 9 -i "$video" -an -t "$7" -pix_fmt yuv420p \
    -vf "crop=$2:$3:$4:$5,fps=30,scale=$6*iw:-1:flags=bicubic" "$work/$1" </dev/null
}
# `frame FILE OUTPUT REGION OVERLAY-OPTION...` draws over the fourteenth frame, of which the tracker has seen the ones before.
frame() {
  gst-launch-1.0 -q filesrc "location=$work/$1" ! y4mdec ! videoconvert \
    ! roitracker pointer-source=property "pointer-x=$pointer_x" "pointer-y=$pointer_y" "roi-size=$3" \
    ! hapticoverlay "${@:4}" ! videoconvert ! video/x-raw,format=I420 ! y4menc ! filesink "location=$work/drawn.y4m"
  ffmpeg -v error -y -i "$work/drawn.y4m" -vf "select=eq(n\,13)" -frames:v 1 -c:v libwebp -quality 60 "$folder/$2" </dev/null
}
cut near.y4m 480 320 10 110 1 0.5
pointer_x=0.323 pointer_y=0.55 # the leaves at 165, 286 of the film
frame near.y4m point.webp 60 style=arrows scale=0
cut close.y4m 160 106 85 233 3 0.5
pointer_x=0.5 pointer_y=0.5
frame close.y4m measure.webp 180 style=full scale=0.25

cut near.y4m 480 320 10 110 1 2
gst-launch-1.0 -m filesrc "location=$work/near.y4m" ! y4mdec ! videoconvert ! roitracker roi-size=60 \
  ! velocityavg post-messages=true \
  ! hapticsink device=sim sim-hand=hold:-0.35,-0.1,0 "alpha=$wind_alpha" "log-location=$work/trace.csv" |
  sed -n 's/.*haptic-motion, pts=(guint64)\([0-9]*\), interval=(guint64)\([0-9]*\), vx=(double)\([^,]*\),.*/\1,\2,\3/p' \
    >"$work/velocities.csv"
gnuplot -e "pipelines='$root/pipelines'; work='$work'; folder='$folder'" "$root/pipelines/paper/how-it-works.gp" ||
  fail "gnuplot could not write into '$folder'; give another folder"
echo "$folder"/{point,measure}.webp "$folder"/{law,time}.svg
