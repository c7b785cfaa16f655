#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# hold.sh: what is pressed on is felt wherever it goes, and nothing else, until it is let go. Everything in the clip moves
# to the right; so a hand that holds feels nothing once the thing has left the frame, and a hand that lets go feels again.

# Runs hold.sh inside the window system: `hold-test.sh press SCRIPT VIDEO LOG`.
# shellcheck disable=SC2016 # $8 is awk's
if [ "${1:-}" = press ]; then
  set -euo pipefail
  set -m # hold.sh gets a process group of its own, as in a terminal
  log=$4
  "$2" "$3" -- "log-location=$log" &
  process=$!
  trap 'kill -- "-$process" 2>/dev/null || true' EXIT
  rows() { awk -F, "NR > 1 && $1 { n++ } END { print n + 0 }" "$log"; }
  # `until_felt AWK-CONDITION`: until 500 rows more fulfil it.
  until_felt() {
    local wanted=$(($(rows "$1") + 500))
    while kill -0 "$process" && [ "$(rows "$1")" -lt "$wanted" ]; do sleep 0.1; done
  }
  window=$(timeout 120 xdotool search --sync --onlyvisible --pid "$process" | tail -n 1)
  xdotool mousemove --window "$window" 100 144 mousemove --window "$window" 106 144
  until_felt '$8 > 0.48'
  xdotool mousedown 1
  until_felt '$8 == 0'
  xdotool mouseup 1
  until_felt '$8 > 0.48'
  kill -INT -- "-$process"
  wait "$process"
  exit
fi

source "$(dirname "$0")/support.sh"

hold=$root/pipelines/hold.sh
clip "$work/clip.mkv" 352 288 30 20 uniform:100,0
clip "$work/short.mkv" 352 288 30 6 uniform:100,0

# `felt_then_gone AGAIN`: 500 rows with the force of the thing, then 500 without any; AGAIN says whether 500 with a force
# follow.
felt_then_gone() {
  awk -F, -v "wanted=$1" '
    NR == 1 { next }
    $8 > 0.48 { if (gone < 500) felt++; else again++ }
    $8 == 0 && felt >= 500 { gone++ }
    END {
      print felt + 0 " rows felt, " gone + 0 " without a force, " again + 0 " felt again"
      exit felt < 500 || gone < 500 || (wanted == "yes" ? again < 500 : again > 0)
    }' "$work/log.csv"
}

promise "without a display a thing is held that nobody presses" env -u DISPLAY -u WAYLAND_DISPLAY \
  "$hold" --at 0.3,0.5 "$work/short.mkv" -- "log-location=$work/log.csv"
promise "its log is sound" sound_log "$work/log.csv" 1 5
promise "it is felt until it has left the frame" felt_then_gone no

promise "a hand that is free is carried along" env -u DISPLAY -u WAYLAND_DISPLAY \
  "$hold" --at 0.3,0.5 --law carry "$work/short.mkv" -- sim-hand=free "log-location=$work/log.csv"
# The thing goes 100 px/s to the right, and the width of the frame, 352 px, is that of the workspace, 50 mm.
# A late tick makes the spring soft, and what it gave then has to be paid: after one, the hand may fall behind.
# shellcheck disable=SC2016 # $1 and $2 are awk's: time and x
promise "with the thing" awk -F, '
  NR > 2 && $1 - before > 0.01 { late++ }
  NR > 1 { before = $1; away = $2 - 0.05 * 100 / 352 * $1 }
  NR > 1 && $2 > 0.003 && away > -0.003 && away < 0.003 { rows++ }
  END { print rows + 0 " rows with the thing, " late + 0 " late ticks"; exit rows < (late ? 200 : 1000) }' "$work/log.csv"

# A line a point: t, x, y, z, pressed.
printf '%s\n' 0,-0.4,0,0,1 4.5,-0.4,0,0,1 4.51,-0.4,0,0,0 >"$work/hand.csv"
promise "a button of the device holds, too" env -u DISPLAY -u WAYLAND_DISPLAY "$hold" --grip "$work/short.mkv" \
  -- device=sim "sim-hand=file:$work/hand.csv" "log-location=$work/log.csv"
promise "until it is released" felt_then_gone yes

need_window_system
command -v xdotool >/dev/null || skip "all of that, but xdotool is not installed"
promise "the mouse presses and lets go" in_window_system "$0" press "$hold" "$work/clip.mkv" "$work/log.csv"
promise "its log is sound" sound_log "$work/log.csv" 1 1
promise "the thing under it was felt until it was gone, and after that what is there" felt_then_gone yes
