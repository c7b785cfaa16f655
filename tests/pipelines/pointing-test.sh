#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The hand decides what is felt: the force follows the object under it, and a hand that moves over a
# still picture feels exactly nothing.

source "$(dirname "$0")/support.sh"

clip "$work/apart.mkv" 352 288 30 3 halves:0,-100,0,100
for hand in '-0.5 1' '0.5 -1'; do
  read -r where direction <<<"$hand"
  promise "two objects moving apart play to their end" \
    "$root/pipelines/play-file.sh" "$work/apart.mkv" \
    -- device=sim "sim-hand=hold:$where,0,0" "log-location=$work/log.csv"
  promise "a hand at $where feels the one under it and not the other" \
    felt "$work/log.csv" 0 "$(awk "BEGIN { print 0.5 * $direction }")"
done

# The value in use is notified; -v shows it.
gst-launch-1.0 -v filesrc "location=$work/apart.mkv" ! decodebin ! videoconvert ! roitracker \
  ! velocityavg ! hapticsink device=sim sim-hand=hold:0.5,0,0 >"$work/output"
at_three_quarters() {
  sed -n 's/.*roitracker0: pointer-x = //p' "$work/output" | tail -n 1 |
    awk '{ found = $1 >= 0.74 && $1 <= 0.76 } END { exit !found }'
}
promise "a hand half way to the right points at three quarters of the picture" at_three_quarters

clip "$work/still.mkv" 352 288 30 3 uniform:0,0
promise "a still video plays to its end" \
  "$root/pipelines/play-file.sh" "$work/still.mkv" \
  -- device=sim sim-hand=circle:0.8,1 "log-location=$work/log.csv"
promise "the hand moved" in_log "$work/log.csv" 'time < 1 || time > 2.5 || x * x + y * y > 0.015 ^ 2'
promise "and felt exactly nothing" in_log "$work/log.csv" 'fx == 0 && fy == 0 && fz == 0'
