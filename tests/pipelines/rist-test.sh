#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# send-ts.sh over RIST: what the hand points at is felt, and both ends stop as they should.

source "$(dirname "$0")/support.sh"
for element in ristsrc ristsink; do
  gst-inspect-1.0 --exists "$element" || skip "$element is not installed (package gstreamer1.0-plugins-bad)"
done
unset DISPLAY WAYLAND_DISPLAY

# The left half moves up, the right half down.
clip "$work/halves.mkv" 352 288 30 12 halves:0,-100,0,100
port=$(free_ports 4)

timeout -k 10 120 "$root/pipelines/send-ts.sh" --rist --port "$port" "$work/halves.mkv" >"$work/sender" 2>&1 &
sender=$!
receive() {
  timeout -k 10 60 "$interrupt_at" "$work/log.csv" 1 'time >= 5' "$root/pipelines/send-ts.sh" --receive --rist --port "$port" \
    -- device=sim sim-hand=hold:0.6,0,0 "log-location=$work/log.csv" >"$work/receiver" 2>&1 || {
    cat "$work/receiver"
    return 1
  }
}
# In its last second the hand, in the right half, feels this half.
felt_down() {
  awk -F, 'NR > 1 { at[NR] = $1; fy[NR] = $9 }
    END {
      for (i = 2; i <= NR; i++) if (at[i] > at[NR] - 2 && at[i] < at[NR] - 1) { rows++; down += fy[i] < -0.3 }
      print down + 0 " of " rows + 0 " rows push down"
      exit !(rows > 500 && down > 0.95 * rows && fy[NR] == 0)
    }' "$work/log.csv"
}
sender_ended() {
  wait "$sender" || { cat "$work/sender"; return 1; }
}
promise "a receiver plays until Ctrl-C" receive
promise "the hand there chooses what is felt, and at the end nothing is" felt_down
promise "the sender ends with its film" sender_ended
