#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws the pictures of docs/elements/hapticoverlay.md from the film of the demonstration.
#
#   marks.webp       a frame with all marks of a measurement, and what each of them means
#   held-thing.webp  what is held: a leaf, a place in the crown, a corner of the flag that is hidden, nothing in the sky
#
# Usage: pipelines/paper/overlay-pictures.sh FOLDER
#   FOLDER  where the pictures go, for example docs/images/overlay

source "$(dirname "$0")/film-pictures.sh"

share() { awk "BEGIN { print $1 / $2 }"; }
# `frame NAME CROP X,Y NUMBER PROPERTY...` draws over a part of the frames from 7 s on, with the hand at X,Y px of this
# part, and keeps the frame with this number as $work/NAME.png. It runs in real time, as the device that it simulates.
frame() {
  local x=${3%,*} y=${3#*,} size=${2%:*:*}
  ffmpeg -v fatal -y -ss 7 -i "$video" -an -t 2 -pix_fmt yuv420p -vf "crop=$2,fps=30,$scale" "$work/film.y4m" </dev/null
  gst-launch-1.0 -q filesrc "location=$work/film.y4m" ! y4mdec ! videoconvert ! clocksync \
    ! roitracker pointer-source=property "pointer-x=$(share "$x" "${size%:*}")" "pointer-y=$(share "$y" "${size#*:}")" \
      "${@:5}" ! tee name=t \
    t. ! queue max-size-buffers=1 ! hapticoverlay "${overlay[@]}" ! videoconvert ! video/x-raw,format=I420 ! y4menc \
    ! filesink "location=$work/drawn.y4m" \
    t. ! queue max-size-buffers=1 ! velocityavg ! hapticsink device=sim latency-mode=immediate "alpha=$wind_alpha"
  ffmpeg -v error -y -i "$work/drawn.y4m" -vf "select=eq(n\,$4)" -frames:v 1 "$work/$1.png" </dev/null
}

scale="scale=3*iw:-1:flags=bicubic" overlay=(style=full)
frame measured 160:120:85:226 80,60 8 roi-size=180
gnuplot -e "pipelines='$root/pipelines'; work='$work'" "$root/pipelines/paper/overlay-marks.gp"
ffmpeg -v error -y -i "$work/marks.png" -c:v libwebp -quality 70 "$folder/marks.webp" </dev/null

scale=null overlay=(style=arrows)
frame held 320:240:80:0 160,108 40 pressed=true roi-size=60
frame about 320:240:260:60 160,120 50 pressed=true roi-size=60
frame hidden 320:240:640:100 224,127 15 pressed=true roi-size=60
frame nothing 320:240:560:0 112,81 40 pressed=true roi-size=60
ffmpeg -v error -y -i "$work/held.png" -i "$work/about.png" -i "$work/hidden.png" -i "$work/nothing.png" \
  -filter_complex hstack=inputs=4 -c:v libwebp -quality 60 "$folder/held-thing.webp" </dev/null
echo "$folder"/{marks,held-thing}.webp
