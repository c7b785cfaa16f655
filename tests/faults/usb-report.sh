#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Measures the times that docs/reliability.md promises for a device on USB, and prints them as a table.
# The tests themselves do not judge times. Nothing else should run meanwhile.
#
# Usage: tests/faults/usb-report.sh [BUILD [REPLIES]]
#   BUILD    the build folder, build if not given
#   REPLIES  fuzzed replies for each controller, 1000000 if not given

set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "${1:-build}" && pwd)
export FEELING_WIND_FUZZ_REPLIES=${2:-1000000} FEELING_WIND_UNPLUGS=200 FEELING_WIND_KILLS=200 FEELING_WIND_READY=1000
export SPIDAR_GEOMETRY_PATH=$root/spidar/geometry SPIDAR_GUARDIAN=$build/spidar/spidar-guardian
export GST_PLUGIN_PATH_1_0=$build/gst-plugins GST_REGISTRY=$build/tests/usb/registry.bin GST_REGISTRY_FORK=no
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# `measure NAME COMMAND...` runs a test program and remembers whether it passed.
declare -A passed
measure() {
  local name=$1
  shift
  if "$@" >>"$log" 2>&1; then passed[$name]=yes; else passed[$name]=no; fi
}
measure guardian "$build/tests/faults/faults-guardian" --gtest_filter='*F1_*:*F2_*:*F3_*'
measure group "$build/tests/faults/faults-guardian" --gtest_filter='*Cgroup*:*Service*'
measure guarded umockdev-wrapper "$build/tests/usb/usb-realtime" --gtest_filter='*Guarded*:*Stamped*'
measure fuzz umockdev-wrapper "$build/tests/usb/usb" --gtest_filter='*/Fuzz.*'
measure tick umockdev-wrapper "$build/tests/usb/usb" --gtest_filter='*/Ticks.*:OurPart.*'
measure unplug umockdev-wrapper "$build/tests/usb/usb" --gtest_filter='*/Unplug.*'
measure sink umockdev-wrapper "$build/tests/usb/usb-realtime" --gtest_filter='*F13*:*InReady*'
measure refusals umockdev-wrapper "$build/tests/usb/usb" --gtest_filter='Refusals.*'
measure stall umockdev-wrapper "$build/tests/usb/usb" --gtest_filter='*Stalled*'

# The largest of what the tests measured under a name.
largest() {
  awk -v name="$1" '$1 == "measured" && $2 == name && (!n++ || $3 > most) { most = $3 } END { if (n) printf "%.3g", most; else print "?" }' "$log"
}
failed=0
# `row WHAT TARGET MEASURED TEST [LIMIT]`: kept if the number that MEASURED begins with is within LIMIT; without a
# LIMIT, if the test passed. A test that did not run has measured nothing.
row() {
  local verdict=kept
  if [[ $3 = *\?* ]]; then
    verdict='**not measured**'
  elif [ -n "${5:-}" ]; then
    awk -v value="${3%% *}" -v limit="$5" 'BEGIN { exit !(value <= limit) }' || verdict='**missed**'
  elif [ "${passed[$4]}" = no ]; then
    verdict='**missed**'
  fi
  [ "$verdict" = kept ] && [ "${passed[$4]}" = yes ] || failed=1
  echo "| $1 | $2 | $3 | $verdict |"
}

echo "$(nproc) x $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(c++ --version | head -n 1)"
echo
echo "| what | target | measured | |"
echo "|---|---|---|---|"
row "tick: exchange, pose, law, safety chain, tensions; emulated usbfs" "p99 ≤ 200 µs" "$(largest tick-p99-us) µs" tick 200
row "of it our own part, without USB" "p99 ≤ 15 µs" "$(largest own-part-p99-us) µs" tick 15
row "kill -9 at full force → minimum tension, slowest of 200" "≤ 5 ms" "$(largest kill-to-rest-ms) ms" guardian 5
row "SIGSTOP → minimum tension, slowest of 200" "≤ 15 ms" "$(largest stop-to-rest-ms) ms" guardian 15
row "stopped twice → minimum tension, slowest of 200" "≤ 15 ms" "$(largest double-stop-to-rest-ms) ms" guardian 15
row "dead guardian noticed" "≤ 10 ms" "$(largest dead-guardian-noticed-ms) ms" guardian 10
row "guardian stopped → minimum tension, slowest of 400" "≤ 10 ms" "$(largest stopped-guardian-to-rest-ms) ms" guarded 10
row "cgroup killed → minimum tension" "≤ 5 ms" "$(largest cgroup-kill-to-rest-ms) ms" group 5
row "cgroup killed, user service → minimum tension" "≤ 5 ms" "$(largest service-cgroup-kill-to-rest-ms) ms" group 5
row "session killed, user service → minimum tension" "≤ 5 ms" "$(largest service-kill-to-rest-ms) ms" group 5
row "replies behind after random faults" "0" "0" guarded
row "faults counted in 1000 round trips to READY" "0" "$(largest ready-faults)" sink 0
row "unplugged at random instants, 200 for the library, until noticed" "≤ 10 ms" "$(largest unplug-noticed-ms) ms" unplug 10
row "unplugged at random instants, 200 in a pipeline whose film goes on, until faulted" "≤ 10 ms" "$(largest unplug-faulted-ms) ms" sink 10
row "plugged in again → opened, disarmed" "≤ 2 s" "$(largest replug-reopened-ms) ms" sink 2000
row "fuzzed replies, each controller" "pose and tensions within limits" "$FEELING_WIND_FUZZ_REPLIES" fuzz
row "pose through quantised counts" "≤ 0.05 mm, ≤ 0.1°" "$(largest pose-error-mm) mm, $(largest pose-error-degrees)°" tick
row "endpoint stalls → the next exchange answered" "≤ 20 ms" "$(largest stall-cleared-ms) ms" stall 20
row "refusals, each with its remedy, slowest of 13 cases" "≤ 200 ms" "$(largest refusal-ms) ms" refusals 200
[ "$failed" = 0 ] || grep -A 6 -E 'Failure|FAILED' "$log" >&2
exit "$failed"
