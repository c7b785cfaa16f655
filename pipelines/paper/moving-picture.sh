#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Makes the animation of the README (WebP, 480 px wide, 1.7 s): a video with velocity and force drawn over it, and
# a legend. Each frame shows both arrows, the first one too: some readers see only that.
#
# Usage: pipelines/paper/moving-picture.sh [--hold] [VIDEO] OUTPUT
#   VIDEO   a file or URL; its beginning is used, with the pointer in the middle. Default: the film of the demonstration, with
#           the pointer in the crown of the tree while a gust bends it, and arrows enlarged.
#   --hold  what is under the pointer is held from the beginning on (2 s): a ring about it, and its path
#   OUTPUT  the file, with the ending .webp
#
# Example:
#   pipelines/paper/moving-picture.sh --hold hold.webp
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! clocksync ! roitracker ! tee name=t \
#       t. ! queue max-size-buffers=1 ! hapticoverlay ! ... \
#       t. ! queue max-size-buffers=1 ! velocityavg ! hapticsink device=sim latency-mode=immediate
#
# It runs in real time: the overlay draws the force that the simulated device currently feels.

source "$(dirname "$0")/../shared/common.sh"
source "$(dirname "$0")/../shared/packages.sh"

# The first second is left out: the force of the device begins with a fade.
seconds=2.7 before=1
# Velocity and force: on a dark picture the blue is lighter.
orange=E69F00 blue=56B4E9 green=009E73
hold=no
read_options hold "$@"
case ${#inputs[@]} in
1) video='' output=${inputs[0]} ;;
2) video=${inputs[0]} output=${inputs[1]} ;;
*) fail "there is no file to write into; name one, see --help" ;;
esac
[[ $output = *.webp ]] || fail "the name of the output must end in .webp, not '$output'"
command -v ffmpeg >/dev/null || fail "ffmpeg is not installed; as root run: apt-get install ffmpeg"
use_elements roitracker velocityavg hapticsink hapticoverlay
need_packaged_elements y4mdec

if [ -n "$video" ]; then
  need_input "$video"
  sink=("sim-hand=hold:0,0,0") cut=() filter=fps=30 tracker=() overlay=()
elif [ $hold = yes ]; then
  video=$(wind_film)
  # A tuft of leaves before the sky, which goes 57 px from end to end.
  sink=("sim-hand=hold:0,0,0" "alpha=$wind_alpha") cut=(-ss 7)
  filter=crop=324:216:73:12,fps=30 tracker=(roi-size=60 pointer-x=0.515 pointer-y=0.444) overlay=()
else
  video=$(wind_film)
  # Here and then the leaves of a low branch never stop for as long.
  sink=("sim-hand=hold:-0.35,-0.1,0" "alpha=$wind_alpha") cut=(-ss 8.15)
  filter=crop=480:320:10:110,fps=30 tracker=(roi-size=60) overlay=(scale=1)
fi

names=(velocity force)
if [ $hold = yes ]; then
  seconds=3 names+=(held)
  tracker+=(pointer-source=property pressed=true)
fi

# Prints the filter that draws the legend into the lower left corner.
legend() {
  local left=6 name='' colour
  printf 'drawbox=x=0:y=ih-26:w=%d:h=26:color=black@0.6:t=fill' $((85 * ${#names[@]}))
  for name in "${names[@]}"; do
    case $name in velocity) colour=$orange ;; force) colour=$blue ;; *) colour=$green ;; esac
    printf ',drawbox=x=%d:y=ih-15:w=16:h=4:color=0x%s:t=fill' $left $colour
    printf ',drawtext=font=Sans:fontsize=14:fontcolor=white:text=%s:x=%d:y=h-13-ascent/2' "$name" $((left + 22))
    left=$((left + 92))
  done
}

work=$(mktemp -d)
trap 'rm -rf "$work"; [ -s "$output" ] || rm -f "$output"' EXIT
: 2>/dev/null >>"$output" || fail "'$output' cannot be written; give another name"

ffmpeg -v error "${cut[@]}" -i "$video" -an -t "$seconds" -pix_fmt yuv420p \
  -vf "$filter,scale=480:2*round(240/dar),setsar=1" "$work/film.y4m" </dev/null 2>"$work/log" ||
  fail "'$video' is not a video that ffmpeg can play; try another one ($(tail -n 1 "$work/log"))"
gst-launch-1.0 -q filesrc "location=$work/film.y4m" ! y4mdec ! videoconvert ! clocksync \
  ! roitracker "${tracker[@]}" ! tee name=t \
  t. ! queue max-size-buffers=1 ! hapticoverlay style=arrows "force-color=$((0xFF$blue))" "${overlay[@]}" ! videoconvert \
  ! video/x-raw,format=I420 ! videorate drop-only=true ! video/x-raw,framerate=12/1 ! y4menc ! filesink "location=$work/drawn.y4m" \
  t. ! queue max-size-buffers=1 ! velocityavg ! hapticsink device=sim latency-mode=immediate "${sink[@]}" ||
  fail "'$video' could not be played; see GStreamer's message above"
ffmpeg -v error -y -ss "$before" -i "$work/drawn.y4m" -vf "$(legend)" -c:v libwebp_anim -loop 0 -quality 40 \
  -compression_level 6 "$output" </dev/null || fail "ffmpeg could not write '$output'; give another name"
echo "$output"
