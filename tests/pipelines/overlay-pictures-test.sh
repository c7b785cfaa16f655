#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# overlay-pictures.sh draws the pictures of docs/elements/hapticoverlay.md.

source "$(dirname "$0")/support.sh"
command -v gnuplot >/dev/null || skip "gnuplot is not installed"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"

draw() { "$root/pipelines/paper/overlay-pictures.sh" "$work" >"$work/said" 2>&1 || { cat "$work/said"; return 1; }; }
promise "one command draws them" draw
for picture in marks held-thing; do
  promise "$picture.webp is there, and at most 60 kB" test -s "$work/$picture.webp" -a "$(wc -c <"$work/$picture.webp")" -le 60000
done
! "$root/pipelines/paper/overlay-pictures.sh" "$work/none" 2>"$work/said" || exit 1
promise "without a folder it says what to do" grep -q "make it, or give another" "$work/said"
