#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# spidar-calibrate as a person uses it, who answers its questions while the simulated device runs.
# Usage: calibrate-test.sh SPIDAR-INFO SPIDAR-CALIBRATE

info=$1 calibrate=$2
source "$(dirname "$0")/expect.sh"

# `answers TEXT...`: from the first question on, which the tool asks when its device runs. The grip has moved
# before the second empty answer, which says that it is there.
answers() {
  local answer empty=0
  for _ in {1..1200}; do
    grep -q 'press Enter' "$work/heard" && break
    sleep 0.05
  done
  for answer; do
    [ -n "$answer" ] || empty=$((empty + 1))
    [ -n "$answer" ] || [ "$empty" != 2 ] || sleep 3.5
    echo "$answer"
  done
}

dialogue() {
  rm -f "$work/measured.ini"
  : >"$work/heard"
  answers "$@" | "$calibrate" --device sim --sim-hand "file:$work/hand" --output "$work/measured.ini" 2>&1 | tee "$work/heard"
  return "${PIPESTATUS[1]}"
}

# The grip stays in the centre for 2 s after the device has started, then goes 20 mm to the right and stays.
printf '%s\n' 0,0,0,0 2,0,0,0 2.2,0.8,0,0 >"$work/hand"

expect 0 'Written' dialogue '' right up towards '' 20 skip
expect 0 'position' "$info" --device sim --geometry "$work/measured.ini"
# Its scale is what it was, but for what a hand under force is off the centre.
awk -F= '/^metres-per-count/ { d = $2 < 0 ? -$2 : $2; if (d < 1.6e-5 || d > 1.73e-5) exit 1 }' "$work/measured.ini" ||
  { echo "FAILED: the measured scale is wrong"; failed=1; }
expect 0 'is turned over' dialogue '' left up towards '' -20 skip
expect 0 'Written' dialogue '' right up towards '' 20 '' 0.5
grep -q '^volts-per-newton=0.7305' "$work/measured.ini" ||
  { echo "FAILED: half the force needs twice the voltage"; failed=1; }
expect 2 'cannot be written' "$calibrate" --device sim --output "$work/nowhere/measured.ini"
expect 1 'exists already' "$calibrate" --device sim --output "$work/measured.ini"
expect 1 'stands turned' dialogue '' up
expect 1 'do not pull' dialogue '' none
expect 1 'nothing has been written' dialogue '' right
expect 1 'in the right direction' dialogue '' right up towards '' -20
expect 1 'does not belong to this device' dialogue '' right up towards '' 900
expect 1 'is not a number' dialogue '' right up towards '' twenty 2000

# The grip is let go while it pulls, and goes to and fro for 1 s, 40 mm in 10 ms: the answer then counts for nothing.
awk 'BEGIN {
  print "0,0,0,0\n2,0,0,0"
  for (i = 1; i <= 101; ++i)
    printf "%.2f,%.1f,0,0\n", 2 + i / 100, i % 2 ? 0.8 : -0.8
}' >"$work/hand"
let_go() {
  { answers ''; sleep 3.5; printf '%s\n' none right up towards '' 20 skip; } |
    "$calibrate" --device sim --sim-hand "file:$work/hand" --output "$work/let-go.ini" 2>&1 | tee "$work/heard"
  return "${PIPESTATUS[1]}"
}
: >"$work/heard"
expect 0 'The pull ended before the answer' let_go
[ "$failed" = 0 ]
