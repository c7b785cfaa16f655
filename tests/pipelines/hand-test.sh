#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The hand decides what is felt of a file that plays, with and without a window: the force follows the object under the
# hand or the mouse, and a hand that moves over a still picture feels exactly nothing.

# Runs mouse.sh inside the window system: `hand-test.sh move SCRIPT VIDEO LOG`.
# shellcheck disable=SC2016 # $9 is awk's
if [ "${1:-}" = move ]; then
  set -euo pipefail
  set -m # mouse.sh gets a process group of its own, as in a terminal
  "$2" "$3" -- "log-location=$4" &
  process=$!
  trap 'kill -- "-$process" 2>/dev/null || true' EXIT
  # `rows AWK-CONDITION`: how many rows of the log fulfil it.
  rows() { awk -F, "NR > 1 && $1 { n++ } END { print n + 0 }" "$log"; }
  # `stay X AWK-CONDITION`: the mouse stays about there until 500 rows more fulfil it.
  stay() {
    local wanted=$(($(rows "$2") + 500))
    while kill -0 "$process" && [ "$(rows "$2")" -lt "$wanted" ]; do
      # To two places side by side: the window reports moves, not a mouse at rest.
      xdotool mousemove --window "$window" $(($1 - 8)) 144
      sleep 0.1
      xdotool mousemove --window "$window" "$1" 144
      sleep 0.1
    done
  }
  log=$4
  window=$(timeout 120 xdotool search --sync --onlyvisible --pid "$process" | tail -n 1)
  stay 88 '$9 > 0.48'
  stay 264 '$9 < -0.48'
  kill -INT -- "-$process"
  wait "$process"
  exit
fi

source "$(dirname "$0")/support.sh"

# The left half moves up, the right half down.
clip "$work/apart.mkv" 352 288 30 20 halves:0,-100,0,100
for hand in '-0.5 1' '0.5 -1'; do
  read -r where direction <<<"$hand"
  promise "two objects moving apart are felt until Ctrl-C" \
    "$interrupt_at" "$work/log.csv" 500 "fy * $direction >= 0.48" \
    "$root/pipelines/play-file.sh" "$work/apart.mkv" \
    -- device=sim "sim-hand=hold:$where,0,0" "log-location=$work/log.csv"
  promise "a hand at $where feels the one under it and not the other" \
    felt "$work/log.csv" 0 "$(awk "BEGIN { print 0.5 * $direction }")"
  promise "its log is sound" sound_log "$work/log.csv" 1 0.5
  promise "and ends without a force" ends_without_force "$work/log.csv"
done

# The value in use is notified; -v shows it.
clip "$work/short.mkv" 352 288 30 1 halves:0,-100,0,100
gst-launch-1.0 -v filesrc "location=$work/short.mkv" ! decodebin ! videoconvert ! roitracker \
  ! velocityavg ! hapticsink device=sim sim-hand=hold:0.5,0,0 >"$work/output"
at_three_quarters() {
  sed -n 's/.*roitracker0: pointer-x = //p' "$work/output" | tail -n 1 |
    awk '{ found = $1 >= 0.74 && $1 <= 0.76 } END { exit !found }'
}
promise "a hand half way to the right points at three quarters of the picture" at_three_quarters

clip "$work/still.mkv" 352 288 30 2 uniform:0,0
promise "a still video plays to its end" \
  "$root/pipelines/play-file.sh" "$work/still.mkv" \
  -- device=sim sim-hand=circle:0.8,1 "log-location=$work/log.csv"
promise "the hand moved" in_log "$work/log.csv" 'time < 1 || time > 1.8 || x * x + y * y > 0.015 ^ 2'
promise "and felt exactly nothing" in_log "$work/log.csv" 'fx == 0 && fy == 0 && fz == 0'

if tree=$(found_opencv_file tree.avi); then
  promise "tree.avi plays until it was felt" "$interrupt_at" "$work/log.csv" 1 'fx ^ 2 + fy ^ 2 >= 0.02 ^ 2' \
    "$root/pipelines/play-file.sh" "$tree" \
    -- device=sim "sim-hand=file:$root/pipelines/films/hands/tree-hand.csv" "log-location=$work/log.csv"
  some_force() {
    ! in_log "$work/log.csv" 'force < 0.02' >"$work/first"
  }
  promise "the twig under the hand is felt" some_force
  promise "its log is sound" sound_log "$work/log.csv" 1 0.5
fi

need_window_system
clip "$work/clip.mkv" 352 288 30 3 uniform:0,-100
promise "beside a window a clip plays to its end, with options for hapticsink" in_window_system \
  "$root/pipelines/play-file-with-display.sh" "$work/clip.mkv" \
  -- device=sim max-force=2 alpha=0.02 "log-location=$work/log.csv"
promise "its log is sound" sound_log "$work/log.csv" 2 3
read -r fx fy < <(force_of 0 -100 2 0.02)
promise "its force is that of the motion and the options" felt "$work/log.csv" "$fx" "$fy" 2

command -v xdotool >/dev/null || skip "all of that, but xdotool is not installed"
promise "the mouse moves over a playing video until Ctrl-C" \
  in_window_system "$0" move "$root/pipelines/mouse.sh" "$work/apart.mkv" "$work/log.csv"
promise "the log is sound" sound_log "$work/log.csv" 1 1
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
