#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A film that is played slower, as it is, and faster gives the force of the motion as it is seen.

source "$(dirname "$0")/support.sh"

clip "$work/clip.mkv" 352 288 30 4 uniform:80,0
for speed in 0.5 1 2; do
  promise "the clip plays at $speed times its speed" \
    "$root/pipelines/playback-speed.sh" --speed "$speed" "$work/clip.mkv" \
    -- device=sim "log-location=$work/log.csv"
  promise "its log is sound" sound_log "$work/log.csv" 1 1
  read -r fx fy < <(force_of "$(awk "BEGIN { print 80 * $speed }")" 0)
  promise "its force is equation 5 of the motion as seen" felt "$work/log.csv" "$fx" "$fy"
done
promise "a speed that is none is an error" test "$(
  "$root/pipelines/playback-speed.sh" --speed fast "$work/clip.mkv" 2>&1 | grep -c 'a number from 0.01'
)" = 1
