#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A video is felt at another machine, over a network that loses packets, delays them and changes their
# order, and the hand over there chooses what is felt.
#
# Usage: network-test.sh [all]

source "$(dirname "$0")/support.sh"

unset DISPLAY WAYLAND_DISPLAY
clip "$work/apart.mkv" 352 288 30 4 halves:0,-100,0,100

# `over_network LOSS JITTER HAND [no-video]`: the log of the receiver is in $work/log.csv.
over_network() {
  local here there report ways=()
  here=$(free_ports 20)
  there=$((here + 10))
  [ "${4:-}" = no-video ] || ways=("$here:$there")
  for report in 1 3; do
    ways+=("$((here + report)):$((there + report))" "$((there + report + 4)):$((here + report + 4))")
  done
  "$LOSSY_RELAY" "$1" "$2" 1 "${ways[@]}" "$((here + 2)):$((there + 2))" "$((there + 4)):$((here + 4))" &
  send_through "$!" "$here" "$work/apart.mkv" "$root/pipelines/receive.sh" --port "$there" \
    -- device=sim "sim-hand=hold:$3" "log-location=$work/log.csv"
}

# The force has the right direction, and once it has, it never turns round. (Before the pointer has arrived at the
# sender, the middle of the frame is felt.)
felt_in_direction() {
  awk -F, -v "direction=$2" 'NR > 1 && $9 * direction > 0.4 { right++ } right > 100 && $9 * direction < -0.1 { wrong++ }
    END { print right + 0 " rows in the right direction, then " wrong + 0 " in the other"
          exit !(right > 500 && !wrong) }' "$1"
}

# Loss in %, jitter in ms, where the hand is, and the direction of the object there. Without `all`, each once.
networks=('0 0 -0.5,0,0 1' '5 12 0.5,0,0 -1')
[ "${1:-}" != all ] || networks+=('0 0 0.5,0,0 -1' '5 12 -0.5,0,0 1')
for network in "${networks[@]}"; do
  read -r loss jitter where direction <<<"$network"
  promise "loss of $loss %, jitter of $jitter ms: it runs" over_network "$loss" "$jitter" "$where"
  promise "a hand at $where feels the object under it" felt_in_direction "$work/log.csv" "$direction"
  promise "the force makes no step" smooth "$work/log.csv"
  promise "the log is sound" sound_log "$work/log.csv" 1 3
done

# Where the first picture is lost, the force does not wait for the next: here none comes at all.
without_video() { over_network 0 0 -0.5,0,0 no-video && felt_in_direction "$work/log.csv" 1; }
promise "without a picture the track is felt" without_video
