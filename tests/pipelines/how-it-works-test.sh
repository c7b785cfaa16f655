#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# how-it-works.sh draws the four pictures of docs/how-it-works.md.

source "$(dirname "$0")/support.sh"
command -v gnuplot >/dev/null || skip "gnuplot is not installed"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"

draw() { "$root/pipelines/paper/how-it-works.sh" "$work" >"$work/said" 2>&1 || { cat "$work/said"; return 1; }; }
promise "one command draws them" draw
for picture in point.webp measure.webp law.svg time.svg; do
  promise "$picture is there, and at most 40 kB" test -s "$work/$picture" -a "$(wc -c <"$work/$picture")" -le 40000
done
points() { [ "$(grep -o "use xlink:href='#gpPt6'" "$work/time.svg" | wc -l)" -ge "$1" ]; }
promise "time.svg has a velocity for each frame of 0.8 s" points 24
promise "law.svg has the worked number" grep -q "100 px/s give 0.5 N" "$work/law.svg"
! "$root/pipelines/paper/how-it-works.sh" "$work/none" 2>"$work/said" || exit 1
promise "without a folder it says what to do" grep -q "make it, or give another" "$work/said"
