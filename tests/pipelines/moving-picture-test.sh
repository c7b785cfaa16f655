#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# moving-picture.sh makes a picture that moves, with what is measured and felt drawn over it.

source "$(dirname "$0")/support.sh"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"
gst-inspect-1.0 --exists webpdec || skip "webpdec is not installed (package gstreamer1.0-plugins-bad)"

# At 30 pictures a second: to the right and up, 2 px a picture.
clip "$work/clip.mkv" 352 288 30 2 uniform:60,-60
picture=$work/moving.webp
"$root/pipelines/paper/moving-picture.sh" "$work/clip.mkv" "$picture"

number() { # OFFSET BYTES, little endian
  od -An -tu1 -j "$1" -N "$2" "$picture" | awk '{ for (i = NF; i; i--) n = 256 * n + $i; print n }'
}
frames() { grep -c ANMF <(grep -oa ANMF "$picture"); }
promise "two seconds are thirty pictures" test "$(frames)" -ge 28 -a "$(frames)" -le 31
promise "320 px wide" test "$(number 24 3)" = 319
promise "as high as wide pictures are" test "$(number 27 3)" = 261
promise "it goes on for ever" test "$(number 42 2)" = 0

# The twentieth picture as a file of its own.
start=$(grep -obUa 'VP8 ' "$picture" | sed -n 20p | cut -d: -f1)
length=$(($(number $((start + 4)) 4) + 8))
{
  printf 'RIFF'
  for shift in 0 8 16 24; do printf '%b' "\\x$(printf %02x $((length + 4 >> shift & 255)))"; done
  printf 'WEBP'
  dd "if=$picture" iflag=skip_bytes,count_bytes "skip=$start" "count=$length" status=none
} >"$work/frame.webp"
# Of a film that is grey all over.
colours() { # AWK-CONDITION on r, g, b: as many pixels
  gst-launch-1.0 -q filesrc "location=$work/frame.webp" ! webpdec ! videoconvert ! video/x-raw,format=RGB ! fdsink |
    od -An -v -tu1 -w3 | awk "{ r = \$1; g = \$2; b = \$3 } $1 { n++ } END { print n + 0 }"
}
promise "the velocity is drawn in orange" test "$(colours 'r > b + 50')" -ge 50
promise "the force that was felt in blue" test "$(colours 'b > r + 40')" -ge 20

! "$root/pipelines/paper/moving-picture.sh" "$work/clip.mkv" "$work/moving.gif" 2>"$work/said" || exit 1
promise "what it cannot make it refuses" grep -q "must end in .webp" "$work/said"
! "$root/pipelines/paper/moving-picture.sh" "$0" "$picture.new.webp" 2>"$work/said" || exit 1
promise "no video is told from a video" grep -q "is not a video" "$work/said"
