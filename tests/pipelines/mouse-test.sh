#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The mouse over the window points: moved from one object to the other, the force turns round.

# Runs mouse.sh inside the window system: `mouse-test.sh move SCRIPT VIDEO LOG`.
if [ "${1:-}" = move ]; then
  set -euo pipefail
  "$2" "$3" -- "log-location=$4" &
  process=$!
  trap 'kill $process 2>/dev/null || true' EXIT
  window=$(timeout 30 xdotool search --sync --onlyvisible --pid "$process" | tail -n 1)
  for place in 88 264; do
    # To two places side by side: the window tells of moves, not of a mouse at rest.
    xdotool mousemove --window "$window" $((place - 8)) 144
    sleep 1
    xdotool mousemove --window "$window" "$place" 144
    sleep 2
  done
  wait "$process"
  exit
fi

source "$(dirname "$0")/support.sh"
need_window_system
command -v xdotool >/dev/null || skip "xdotool is not installed"

clip "$work/apart.mkv" 352 288 30 9 halves:0,-100,0,100
promise "the mouse moves over a playing video" \
  in_window_system "$0" move "$root/pipelines/mouse.sh" "$work/apart.mkv" "$work/log.csv"
promise "the log is sound" sound_log "$work/log.csv" 1 8
# For more than a second at a stretch up, then down to the end. (The middle of the picture, where the
# pointer begins, belongs to neither.)
turned_round() {
  awk -F, '
    NR == 1 { next }
    { up = $9 > 0.48 ? up + 1 : 0; down = $9 < -0.48 ? down + 1 : 0 }
    up > 1000 { left = 1 }
    left && down > 1000 { right = 1 }
    right && $9 > 0 { wrong = 1 }
    END { print left + 0, right + 0, wrong + 0; exit !(left && right && !wrong) }' "$work/log.csv"
}
promise "the force is that of the object under the mouse" turned_round
