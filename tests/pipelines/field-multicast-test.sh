#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The motion of a whole picture is sent once, and every receiver feels what its own hand points at.

source "$(dirname "$0")/support.sh"

use_elements motionfield hapticconvert
gst-inspect-1.0 --exists rtpklvpay || skip "there is no element rtpklvpay"

# The left half moves up, the right one down.
clip "$work/apart.mkv" 352 288 30 5 halves:0,-100,0,100

port=$(free_ports 2)
hands=('left:-0.5,0,0' 'right:0.5,0,0' 'top-left:-0.5,0.5,0')

# One sender, all receivers at once; their logs are in $work/NAME.csv.
multicast() {
  local hand receivers=() status=0 receiver
  for hand in "${hands[@]}"; do
    "$root/pipelines/field-multicast.sh" --receive --port "$port" -- device=sim "sim-hand=hold:${hand#*:}" \
      "log-location=$work/${hand%%:*}.csv" >"$work/${hand%%:*}.out" 2>&1 &
    receivers+=($!)
  done
  for hand in "${hands[@]}"; do
    until grep -q PLAYING "$work/${hand%%:*}.out"; do sleep 0.2; done
  done
  timeout -k 10 60 "$root/pipelines/field-multicast.sh" --port "$port" "$work/apart.mkv" >"$work/sender" 2>&1 ||
    status=1
  sleep 0.5
  for receiver in "${receivers[@]}"; do
    kill -INT "$receiver"
    wait "$receiver" || status=1
  done
  ! grep -E '^(WARNING|ERROR)' "$work"/*.out "$work/sender" || status=1
  return "$status"
}

# `felt_towards NAME SIGN`: in that direction, and never in the other.
felt_towards() {
  awk -F, -v "sign=$2" 'NR > 1 && $9 * sign > 0.4 { right++ } NR > 1 && $9 * sign < -0.1 { wrong++ }
    END { print right + 0 " ms in the right direction, " wrong + 0 " in the other"
          exit !(right > 500 && wrong == 0) }' "$work/$1.csv"
}

promise "one sender and three receivers run" multicast
promise "the hand on the left feels the motion up" felt_towards left 1
promise "the hand on the right feels the motion down" felt_towards right -1
promise "the third feels its own place too" felt_towards top-left 1
for hand in "${hands[@]}"; do
  promise "the log of ${hand%%:*} is sound" sound_log "$work/${hand%%:*}.csv" 1 4
done
