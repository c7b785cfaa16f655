#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The force of a stream that is tuned into begins with its first picture or before, not after.
#
# `tuned-in-test.sh live` is the part that runs with a window and without.

source "$(dirname "$0")/support.sh"

# `over_network FIRST-LOST [no-video]`: so many packets of the video are lost at its beginning. The receiver's log is in
# $work/log.csv, and what its sinks get in $work/sinks.
over_network() {
  local here there ways=()
  here=$(free_ports 20)
  there=$((here + 10))
  [ "${2:-}" = no-video ] || ways=("$here:$there:$1")
  "$LOSSY_RELAY" 0 0 1 "${ways[@]}" "$((here + 2)):$((there + 2))" "$((there + 4)):$((here + 4))" &
  send_through "$!" "$here" "$work/film.mkv" \
    env GST_DEBUG=basesink:5 "GST_DEBUG_FILE=$work/sinks" GST_DEBUG_NO_COLOR=1 \
    "$root/pipelines/receive.sh" --port "$there" -- device=sim "log-location=$work/log.csv"
}

felt() {
  awk -F, 'NR > 1 && $9 > 0.4 { right++ } END { print right + 0 " rows"; exit !(right > 500) }' "$work/log.csv"
}

# `first_at ELEMENT [NUMBER]`: the running time of the first buffer at a sink, or of that number, s.
first_at() {
  awk -v "element=$1" -v "number=${2:-1}" '/chain_unlocked:.*got times start/ && index($0, "<" element) && ++count == number {
    for (i = 1; i < NF; i++) if ($i == "start:") { split($(i + 1), t, /[:,]/); print t[1] * 3600 + t[2] * 60 + t[3]; exit }
  }' "$work/sinks"
}

# `leads TIME MS [NUMBER]`: the time is at least so many ms before that of the first picture, or of that number.
leads() {
  local picture window=fakesink
  [ -z "${DISPLAY:-}" ] || window=window
  picture=$(first_at $window "${3:-1}")
  echo "$1 s, the picture at $picture s"
  awk -v "time=$1" -v "picture=$picture" -v "least=$2" 'BEGIN { exit !(time && picture && 1000 * (picture - time) >= least) }'
}
force_at() {
  awk -F, 'NR > 1 && $8 ^ 2 + $9 ^ 2 > 0 { print $1; exit }' "$work/log.csv"
}

if [ "${1:-}" = live ]; then
  clip "$work/film.mkv" 352 288 30 4 uniform:0,-100
  promise "no picture comes" over_network 0 no-video
  promise "and the track is felt" felt
  # The first IDR and what depends on it; the next comes a second after it.
  promise "the beginning of the picture is lost" over_network 20
  promise "and the force does not wait for the next" leads "$(force_at)" 300
  promise "the track is felt" felt
  promise "nothing is lost" over_network 0
  # The first frame of a film shows no motion yet: the first sample is that of the second. Until the receiver knows the
  # sender's clock, it comes before that picture, by what the encoder takes.
  promise "the first sample is there with the second picture" leads "$(first_at hapticsink)" -2 2
  exit
fi

unset DISPLAY WAYLAND_DISPLAY
promise "without a window" "$0" live
if command -v xvfb-run >/dev/null; then
  promise "with a window" in_window_system "$0" live
fi

# A film whose key frames are 37 frames apart, and what a receiver has of it that tunes in after PERCENT of the file.
clip "$work/clip.mkv" 160 120 30 8 uniform:37,11
ffmpeg -v error -nostdin -i "$work/clip.mkv" -c:v libx264 -g 37 -keyint_min 37 -sc_threshold 0 -pix_fmt yuv420p "$work/film.mp4"
haptic_track author "$work/film.mp4" >"$work/author" || fail "$(cat "$work/author")"
packets=$(($(stat -c %s "$work/film.haptic.ts") / 188))

# `first_decoded ELEMENT...`: the time stamp of the first buffer behind these elements, s.
first_decoded() {
  gst-launch-1.0 -v filesrc "location=$work/middle.ts" ! tsdemux ! "$@" ! identity silent=false ! fakesink |
    sed -nE '/last-message = chain/s/.* pts: ([0-9]+):([0-9]+):([0-9.]+),.*/\1 \2 \3/p' |
    awk 'NR == 1 { print $1 * 3600 + $2 * 60 + $3 }'
}
felt_with_the_first_frame() {
  local frame field skipped=$((packets * $1 / 100))
  tail -c "+$((skipped * 188 + 1))" "$work/film.haptic.ts" >"$work/middle.ts"
  frame=$(first_decoded h264parse ! avdec_h264)
  field=$(first_decoded meta/x-klv ! hapticconvert ! haptics/x-raw)
  echo "frame at $frame s, field at $field s"
  awk -v "frame=$frame" -v "field=$field" 'BEGIN { exit !(frame && field && field <= frame + 0.034) }'
}
for percent in 3 13 23 31 41 47 53 59 67 71 79; do
  promise "tuned in at $percent %, the first field is there with the first frame" felt_with_the_first_frame $percent
done
