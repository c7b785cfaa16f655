#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Makes the animation of the README (WebP, 320 px wide, some 3 s): a video with motion and force drawn over it.
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! clocksync ! roitracker ! tee name=t \
#       t. ! queue max-size-buffers=1 ! hapticoverlay ! ... \
#       t. ! queue max-size-buffers=1 ! velocityavg ! hapticsink device=sim latency-mode=immediate
#
# It runs in real time: the overlay draws the force that the simulated device currently feels.
#
# Usage: pipelines/paper/moving-picture.sh [VIDEO] OUTPUT
#   VIDEO   a file or URL; its beginning is used, with the pointer in the middle. Default: the film of the demonstration, with the
#           pointer in the crown of the tree, and arrows enlarged.
#   OUTPUT  the file, with the ending .webp

source "$(dirname "$0")/../shared/common.sh"
source "$(dirname "$0")/../shared/packages.sh"

seconds=3.5
case ${1:-} in
--help | -h) show_help && exit ;;
-*) fail "unknown option '$1'; see --help" ;;
esac
case $# in
1) video='' output=$1 ;;
2) video=$1 output=$2 ;;
*) fail "into which file? See --help" ;;
esac
[[ $output = *.webp ]] || fail "the name of the output must end in .webp, not '$output'"
command -v ffmpeg >/dev/null || fail "ffmpeg is not installed; as root run: apt-get install ffmpeg"
use_elements roitracker velocityavg hapticsink hapticoverlay
need_packaged_elements y4mdec

if [ -n "$video" ]; then
  need_input "$video"
  sink=("sim-hand=hold:0,0,0") cut=() filter=fps=30 tracker=() overlay=()
else
  video=$(wind_film)
  sink=("sim-hand=hold:-0.2,0.2,0" "alpha=$wind_alpha") cut=(-ss 4)
  filter=crop=576:432:110:20,fps=30 tracker=(roi-size=48) overlay=(scale=2)
fi

work=$(mktemp -d)
trap 'rm -rf "$work"; [ -s "$output" ] || rm -f "$output"' EXIT
: 2>/dev/null >>"$output" || fail "'$output' cannot be written; give another name"

ffmpeg -v error "${cut[@]}" -i "$video" -an -t "$seconds" -pix_fmt yuv420p \
  -vf "$filter,scale=320:2*round(160/dar),setsar=1" "$work/film.y4m" </dev/null 2>"$work/log" ||
  fail "'$video' is not a video that ffmpeg can play; try another one ($(tail -n 1 "$work/log"))"
gst-launch-1.0 -q filesrc "location=$work/film.y4m" ! y4mdec ! videoconvert ! clocksync \
  ! roitracker "${tracker[@]}" ! tee name=t \
  t. ! queue max-size-buffers=1 ! hapticoverlay "${overlay[@]}" ! videoconvert ! video/x-raw,format=I420 \
  ! videorate drop-only=true ! video/x-raw,framerate=15/1 ! y4menc ! filesink "location=$work/drawn.y4m" \
  t. ! queue max-size-buffers=1 ! velocityavg ! hapticsink device=sim latency-mode=immediate "${sink[@]}" ||
  fail "'$video' could not be played; see GStreamer's message above"
ffmpeg -v error -y -i "$work/drawn.y4m" -c:v libwebp_anim -loop 0 -quality 60 "$output" </dev/null ||
  fail "ffmpeg could not write '$output'; give another name"
echo "$output"
