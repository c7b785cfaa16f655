#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A video is felt at another machine, over a network that loses packets, delays them and changes their
# order, and the hand over there chooses what is felt.

source "$(dirname "$0")/support.sh"

clip "$work/apart.mkv" 352 288 30 5 halves:0,-100,0,100

# `over_network LOSS JITTER HAND`: the log of the receiver is in $work/log.csv.
over_network() {
  local here=$((20000 + RANDOM % 1000 * 10)) there relay receiver status=0
  there=$((here + 20000))
  "$LOSSY_RELAY" "$1" "$2" 1 "$here:$there" "$((here + 2)):$((there + 2))" \
    "$((there + 4)):$((here + 4))" &
  relay=$!
  env -u DISPLAY -u WAYLAND_DISPLAY "$root/pipelines/receive.sh" --port "$there" \
    -- device=sim "sim-hand=hold:$3" "log-location=$work/log.csv" >"$work/receiver" 2>&1 &
  receiver=$!
  until grep -q PLAYING "$work/receiver"; do sleep 0.2; done
  timeout -k 10 60 "$root/pipelines/send.sh" --port "$here" "$work/apart.mkv" >"$work/sender" 2>&1 || status=1
  sleep 1
  kill -INT "$receiver"
  wait "$receiver" || status=1
  kill "$relay"
  wait "$relay" || true
  ! grep -E '^(WARNING|ERROR)' "$work/receiver" "$work/sender" || status=1
  return "$status"
}

# The force changes by no more than slew-rate allows in the time between two rows.
smooth() {
  awk -F, 'NR > 2 {
      step = sqrt(($8 - fx) ^ 2 + ($9 - fy) ^ 2 + ($10 - fz) ^ 2)
      if (step > 20 * ($1 - time) * 1.05 + 0.0005) { print "row " NR ": " step " N"; bad = 1; exit }
    }
    { time = $1; fx = $8; fy = $9; fz = $10 }
    END { exit bad || NR < 3000 }' "$1"
}

# Felt for two seconds at least, and then always that way.
felt_in_direction() {
  awk -F, -v "direction=$2" 'NR > 1 && $9 * direction > 0.4 { right++ } NR > 1 && $9 * direction < -0.4 { wrong++ }
    END { print right " ms in the right direction, " wrong + 0 " in the other"
          exit !(right > 2000 && wrong < 700) }' "$1"
}

for network in '0 0' '5 12'; do
  read -r loss jitter <<<"$network"
  for hand in '-0.5,0,0 1' '0.5,0,0 -1'; do
    read -r where direction <<<"$hand"
    promise "loss of $loss %, jitter of $jitter ms: it runs" over_network "$loss" "$jitter" "$where"
    promise "a hand at $where feels the object under it" felt_in_direction "$work/log.csv" "$direction"
    promise "the force makes no step" smooth "$work/log.csv"
    promise "the log is sound" sound_log "$work/log.csv" 1 5
  done
done
