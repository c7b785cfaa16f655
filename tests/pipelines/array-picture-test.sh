#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# array-picture.sh draws what each actuator of an array does over time.

source "$(dirname "$0")/support.sh"
command -v gnuplot >/dev/null || skip "gnuplot is not installed"

clip "$work/clip.mkv" 352 288 30 2 uniform:90,0
promise "a film gives a picture" "$root/pipelines/paper/array-picture.sh" "$work/array.png" coils-2 "$work/clip.mkv"
promise "in which actuators vibrate" has_colour "$work/array.png" ' [0-6]. [7-9a]. [b-d].' 10000
said=$("$root/pipelines/paper/array-picture.sh" "$work/none.png" jacket "$work/clip.mkv" 2>&1) && status=0 || status=$?
promise "a wrong layout is refused" test "$status" != 0
promise "with its cure" grep -qF 'There is no layout "jacket". Use back-3x4' <<<"$said"
promise "and leaves no picture" test ! -e "$work/none.png"
