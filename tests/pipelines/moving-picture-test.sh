#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# moving-picture.sh makes a picture that moves, with what is measured and felt drawn over it.

source "$(dirname "$0")/support.sh"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"
gst-inspect-1.0 --exists webpdec || skip "webpdec is not installed (package gstreamer1.0-plugins-bad)"

# At 30 frames a second: to the right and up, 2 px a frame.
clip "$work/clip.mkv" 352 288 30 3 uniform:60,-60
picture=$work/moving.webp
"$root/pipelines/paper/moving-picture.sh" "$work/clip.mkv" "$picture"

number() { # OFFSET BYTES, little endian
  od -An -tu1 -j "$1" -N "$2" "$picture" | awk '{ for (i = NF; i; i--) n = 256 * n + $i; print n }'
}
frames() { grep -c ANMF <(grep -oa ANMF "$picture"); }
promise "1.7 s are 20 frames" test "$(frames)" -ge 18 -a "$(frames)" -le 21
promise "480 px wide" test "$(number 24 3)" = 479
promise "as high as wide frames are" test "$(number 27 3)" = 391
promise "it goes on for ever" test "$(number 42 2)" = 0
promise "a page may load it: 400 kB" test "$(wc -c <"$picture")" -le 400000

# `frame NUMBER` writes the colours of a frame into a file of its own; $top and $width say where in the picture it is.
frame() {
  local start length shift
  start=$(grep -obUa ANMF "$picture" | sed -n "$1p" | cut -d: -f1)
  top=$((2 * $(number $((start + 11)) 3))) width=$(($(number $((start + 14)) 3) + 1))
  start=$(grep -obUa 'VP8 ' "$picture" | sed -n "$1p" | cut -d: -f1)
  length=$(($(number $((start + 4)) 4) + 8))
  {
    printf 'RIFF'
    for shift in 0 8 16 24; do printf '%b' "\\x$(printf %02x $((length + 4 >> shift & 255)))"; done
    printf 'WEBP'
    dd "if=$picture" iflag=skip_bytes,count_bytes "skip=$start" "count=$length" status=none
  } >"$work/frame.webp"
}
# The film is grey all over; the legend is in the last 26 rows.
colours() { # AWK-CONDITION on r, g, b and the row y: as many pixels
  gst-launch-1.0 -q filesrc "location=$work/frame.webp" ! webpdec ! videoconvert ! video/x-raw,format=RGB ! fdsink |
    od -An -v -tu1 -w3 |
    awk "{ r = \$1; g = \$2; b = \$3; y = $top + int((NR - 1) / $width) } $1 { n++ } END { print n + 0 }"
}
for number in 1 17; do
  frame $number
  promise "frame $number has the velocity in orange" test "$(colours 'y < 366 && r > b + 50')" -ge 50
  promise "frame $number has the force that was felt in blue" test "$(colours 'y < 366 && b > r + 40')" -ge 20
done
frame 1
promise "the legend has the orange" test "$(colours 'y >= 366 && r > b + 50')" -ge 40
promise "the legend has the blue" test "$(colours 'y >= 366 && b > r + 40')" -ge 40

picture=$work/hold.webp
promise "with --hold the same is held" "$root/pipelines/paper/moving-picture.sh" --hold "$work/clip.mkv" "$picture"
frame 1
promise "a ring about it is green" test "$(colours 'y < 366 && g > r + 40 && g > b + 10')" -ge 40
promise "the legend has the green" test "$(colours 'y >= 366 && g > r + 40 && g > b + 10')" -ge 30

! "$root/pipelines/paper/moving-picture.sh" "$work/clip.mkv" "$work/moving.gif" 2>"$work/said" || exit 1
promise "what it cannot make it refuses" grep -q "must end in .webp" "$work/said"
! "$root/pipelines/paper/moving-picture.sh" "$0" "$picture.new.webp" 2>"$work/said" || exit 1
promise "no video is told from a video" grep -q "is not a video" "$work/said"
