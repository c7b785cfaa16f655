#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The mouse over the window points: moved from one object to the other, the force turns round.

# Runs mouse.sh inside the window system: `mouse-test.sh move SCRIPT VIDEO LOG`.
# shellcheck disable=SC2016 # $9 is awk's
if [ "${1:-}" = move ]; then
  set -euo pipefail
  "$2" "$3" -- "log-location=$4" &
  process=$!
  trap 'kill $process 2>/dev/null || true' EXIT
  # `rows AWK-CONDITION`: how many rows of the log fulfil it.
  rows() { awk -F, "NR > 1 && $1 { n++ } END { print n + 0 }" "$log"; }
  # `stay X AWK-CONDITION`: the mouse stays about there until 500 rows more fulfil it.
  stay() {
    local wanted=$(($(rows "$2") + 500))
    while kill -0 "$process" && [ "$(rows "$2")" -lt "$wanted" ]; do
      # To two places side by side: the window reports moves, not a mouse at rest.
      xdotool mousemove --window "$window" $(($1 - 8)) 144
      sleep 0.2
      xdotool mousemove --window "$window" "$1" 144
      sleep 0.2
    done
  }
  log=$4
  window=$(timeout 60 xdotool search --sync --onlyvisible --pid "$process" | tail -n 1)
  stay 88 '$9 > 0.48'
  stay 264 '$9 < -0.48'
  wait "$process"
  exit
fi

source "$(dirname "$0")/support.sh"
need_window_system
command -v xdotool >/dev/null || skip "xdotool is not installed"

clip "$work/apart.mkv" 352 288 30 15 halves:0,-100,0,100
promise "the mouse moves over a playing video" \
  in_window_system "$0" move "$root/pipelines/mouse.sh" "$work/apart.mkv" "$work/log.csv"
promise "the log is sound" sound_log "$work/log.csv" 1 15
# First up, then down to the end. (The middle of the frame, where the pointer begins, belongs to neither.)
turned_round() {
  awk -F, '
    NR == 1 { next }
    $9 > 0.48 { up++ }
    $9 < -0.48 && up >= 500 { down++ }
    down >= 500 && $9 > 0 { wrong = 1 }
    END { print up + 0 " rows up, then " down + 0 " rows down"; exit up < 500 || down < 500 || wrong }' "$work/log.csv"
}
promise "the force is that of the object under the mouse" turned_round
