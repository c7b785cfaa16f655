#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A video is felt at another machine, over a network that loses packets, delays them and changes their
# order, and the hand over there chooses what is felt.

source "$(dirname "$0")/support.sh"

clip "$work/apart.mkv" 352 288 30 5 halves:0,-100,0,100

# `over_network LOSS JITTER HAND`: the log of the receiver is in $work/log.csv.
over_network() {
  local here there relay receiver status=0
  here=$(free_ports 20)
  there=$((here + 10))
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
  awk -F, '
    NR == 1 { for (i = 1; i <= NF; i++) if ($i == "mono") mono = i; next }
    NR > 2 {
      step = sqrt(($8 - fx) ^ 2 + ($9 - fy) ^ 2 + ($10 - fz) ^ 2)
      if (step > 20 * ($mono - before) * 1.05 + 0.0005) { print "row " NR ": " step " N"; bad = 1; exit }
    }
    { before = $mono; fx = $8; fy = $9; fz = $10 }
    END { exit bad || NR < 1000 }' "$1"
}

# The force has the right direction, and once it has, it never turns round. (Before the pointer has arrived at the
# sender, the middle of the frame is felt.)
felt_in_direction() {
  awk -F, -v "direction=$2" 'NR > 1 && $9 * direction > 0.4 { right++ } right > 100 && $9 * direction < -0.1 { wrong++ }
    END { print right + 0 " rows in the right direction, then " wrong + 0 " in the other"
          exit !(right > 500 && !wrong) }' "$1"
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
