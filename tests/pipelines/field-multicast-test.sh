#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The motion of a whole picture is sent once, and every receiver feels what its own hand points at, also while
# another sender uses the same group.

source "$(dirname "$0")/support.sh"

use_elements motionfield hapticconvert
gst-inspect-1.0 --exists rtpklvpay || skip "there is no element rtpklvpay"

# The left half moves up, the right one down.
clip "$work/apart.mkv" 352 288 30 8 halves:0,-100,0,100
clip "$work/other.mkv" 352 288 30 3 halves:0,100,0,-100

port=$(free_ports 2)
hands=('left:-0.5,0,0' 'right:0.5,0,0' 'top-left:-0.5,0.5,0')

# The other sender waits for its film, which comes when the first is felt.
mkfifo "$work/late"
other_sender() {
  gst-launch-1.0 -q filesrc "location=$work/late" ! matroskademux ! jpegdec ! videoconvert ! motionfield ! hapticconvert \
    ! meta/x-klv ! rtpklvpay ! udpsink host=239.255.43.1 "port=$port" multicast-iface=lo auto-multicast=true sync=false &
  until awk -F, 'NR > 1 && $9 > 0.4 { found = 1 } END { exit !found }' "$work/left.csv"; do sleep 0.1; done
  cat "$work/other.mkv" >"$work/late"
  wait "$!"
}

# One sender, all receivers at once; their logs are in $work/NAME.csv.
multicast() {
  local hand receivers=() status=0 receiver other
  for hand in "${hands[@]}"; do
    "$root/pipelines/field-multicast.sh" --receive --port "$port" -- device=sim "sim-hand=hold:${hand#*:}" \
      "log-location=$work/${hand%%:*}.csv" >"$work/${hand%%:*}.out" 2>&1 &
    receivers+=($!)
  done
  for hand in "${hands[@]}"; do
    until grep -q PLAYING "$work/${hand%%:*}.out"; do sleep 0.2; done
  done
  other_sender &
  other=$!
  timeout -k 10 60 "$root/pipelines/field-multicast.sh" --port "$port" "$work/apart.mkv" >"$work/sender" 2>&1 ||
    { status=1 && echo "the sender failed" && tail -n 5 "$work/sender"; }
  wait "$other" || { status=1 && echo "the other sender failed"; }
  sleep 0.5
  for receiver in "${receivers[@]}"; do
    kill -INT "$receiver"
    wait "$receiver" || { status=1 && echo "a receiver failed"; }
  done
  for hand in "${hands[@]}"; do
    grep -q '^WARNING.*A second sender' "$work/${hand%%:*}.out" ||
      { status=1 && tail -n 5 "$work/${hand%%:*}.out" && echo "${hand%%:*} names no second sender"; }
  done
  ! grep -E '^(WARNING|ERROR)' "$work"/*.out "$work/sender" | grep -v 'A second sender' || status=1
  return "$status"
}

# `felt_towards NAME SIGN`: in that direction, and never in the other.
felt_towards() {
  awk -F, -v "sign=$2" 'NR > 1 && $9 * sign > 0.4 { right++ } NR > 1 && $9 * sign < -0.1 { wrong++ }
    END { print right + 0 " ms in the right direction, " wrong + 0 " in the other"
          exit !(right > 500 && wrong == 0) }' "$work/$1.csv"
}

promise "a sender and three receivers run, and name the other sender" multicast
promise "the hand on the left feels the motion up" felt_towards left 1
promise "the hand on the right feels the motion down" felt_towards right -1
promise "the third feels its own place too" felt_towards top-left 1
for hand in "${hands[@]}"; do
  promise "the log of ${hand%%:*} is sound" sound_log "$work/${hand%%:*}.csv" 1 4
done
