#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Motion fields cross a network that loses packets: how much of the time their force is felt. What is measured
# before is a file, so that a busy machine delays nothing but the packets.

source "$(dirname "$0")/support.sh"

use_elements motionfield hapticconvert hapticsink
for element in rtpklvpay rtpklvdepay mpegtsmux tsdemux; do
  gst-inspect-1.0 --exists "$element" || skip "there is no element $element"
done

seconds=20
clip "$work/apart.mkv" 352 288 30 $seconds halves:60,-100,60,-100
gst-launch-1.0 -q filesrc "location=$work/apart.mkv" ! decodebin ! videoconvert ! motionfield ! hapticconvert \
  ! meta/x-klv ! mpegtsmux ! filesink "location=$work/track.ts"

# `over_network LOSS PORT`: the receiver's log is in $work/LOSS.csv.
over_network() {
  local loss=$1 port=$2 relay receiver status=0
  "$LOSSY_RELAY" "$loss" 0 1 "$port:$((port + 1))" &
  relay=$!
  gst-launch-1.0 -e udpsrc "port=$((port + 1))" \
    caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M \
    ! rtpjitterbuffer latency=30 ! rtpklvdepay ! hapticconvert \
    ! hapticsink device=sim sim-hand=hold:-0.5,0,0 "log-location=$work/$loss.csv" >"$work/$loss.out" 2>&1 &
  receiver=$!
  until grep -qs PLAYING "$work/$loss.out"; do sleep 0.2; done
  gst-launch-1.0 -q filesrc "location=$work/track.ts" ! tsdemux ! meta/x-klv ! rtpklvpay \
    ! udpsink host=127.0.0.1 "port=$port" || status=1
  sleep 1
  kill -INT "$receiver"
  wait "$receiver" || status=1
  kill "$relay"
  wait "$relay" || true
  ! grep '^ERROR' "$work/$loss.out" || status=1
  return "$status"
}

both() {
  local first one status=0
  first=$(free_ports 4)
  over_network 1 "$first" &
  one=$!
  over_network 5 "$((first + 2))" || status=1
  wait "$one" || status=1
  return "$status"
}

# `felt_for LOSS PERCENT`: from the first force to the last, the share of the rows with nine tenths of it. A tick that
# the machine ran too late (128 in hold) makes the force fade for a moment, which is no loss.
felt_for() {
  local force
  force=$(force_of 60 -100 | awk '{ print sqrt($1 ^ 2 + $2 ^ 2) }')
  awk -F, -v "wanted=$force" -v "percent=$2" -v "seconds=$seconds" '
    NR == 1 { for (i = 1; i <= NF; i++) if ($i == "hold") hold = i; next }
    int($hold / 128) % 2 { fades_until = $1 + 0.4 }
    $1 < fades_until { next }
    { felt = sqrt($8 ^ 2 + $9 ^ 2 + $10 ^ 2) >= 0.9 * wanted }
    felt { rows += waiting + 1; right++; waiting = 0; next }
    right { waiting++ }
    END {
      printf "%.2f %% of %.1f s\n", 100 * right / rows, rows / 1000
      exit !(rows > 700 * seconds && right >= percent / 100 * rows)
    }' "$work/$1.csv"
}

promise "fields cross a network that loses packets" both
promise "1 % loss: 99 % of the time are felt" felt_for 1 99
promise "5 % loss: 95 % of the time are felt" felt_for 5 95
for loss in 1 5; do
  promise "$loss % loss: the force makes no step" smooth "$work/$loss.csv"
done
