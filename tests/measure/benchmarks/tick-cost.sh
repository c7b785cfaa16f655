#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Measures what a tick of the loop costs, divided by its cost at an earlier commit: the loop's own part, and the same with
# a hand that touches. Both commits are built alike and tick the same program on one processor, in many short turns, so that
# a machine that slows down slows both. Prints for each part
#   instructions  of a tick, which do not depend on the machine's load; only if valgrind is installed
#   hurry         the time of ticks that follow each other at once
#   wait          the time of ticks with a millisecond between them, as in the loop: caches are cold, and other work is felt
# The times are medians. Their ratio is the median of the turns' ratios, with its quartiles.
#
# Usage: tests/measure/benchmarks/tick-cost.sh [--turns N] [--processor P] COMMIT
#   COMMIT          one that has tests/measure/benchmarks/hapticsink-loop.cpp
#   --turns N       how often each of the two is measured (40)
#   --processor P   the number of the processor (the last one)
#
# Builds in build-tick-cost/, where a second run finds both.

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

turns=40 processor=$(($(nproc --all) - 1))
read_options 'turns= processor=' "$@"
[[ $turns =~ ^[1-9][0-9]*$ ]] || fail "--turns is a number of turns, not '$turns'"
[[ $processor =~ ^[0-9]+$ ]] || fail "--processor is the number of a processor, not '$processor'"
[ ${#inputs[@]} = 1 ] || fail "give one commit to compare with; see --help"
earlier=$(git -C "$root" rev-parse --verify --quiet "${inputs[0]}^{commit}") || fail "'${inputs[0]}' is no commit; see git log"
folder=$root/build-tick-cost benchmarks=tests/measure/benchmarks
# Each tree has the program under the name of one that the earlier commit builds, too.
program=$benchmarks/hapticsink-loop

# `compile TREE` builds the program of $folder/TREE.
compile() {
  local tree=$folder/$1
  cp "$root/$benchmarks/timed-loop.hpp" "$tree/$benchmarks/"
  cp "$root/$benchmarks/tick-cost.cpp" "$tree/$program.cpp"
  {
    [ -f "$tree/build/build.ninja" ] || meson setup "$tree/build" "$tree" -Ddevice=enabled -Dbenchmarks=enabled \
      -Dvision=disabled -Dtrack=disabled -Dview=disabled -Dtests=disabled || return
    ninja -C "$tree/build" $program
  } >"$tree.log" 2>&1
}
mkdir -p "$folder/$earlier" "$folder/now"
git -C "$root" archive "$earlier" | tar -x -C "$folder/$earlier"
git -C "$root" ls-files -z | tar -c -C "$root" --null --files-from=- | tar -x -C "$folder/now"
for tree in "$earlier" now; do
  compile "$tree" || fail "it does not build; read the log $folder/$tree.log"
done

# `tick TREE PART PACE TICKS [PREFIX...]` runs the program of TREE.
tick() {
  SPIDAR_GEOMETRY_PATH=$root/spidar/geometry taskset --cpu-list "$processor" "${@:5}" "$folder/$1/build/$program" "${@:2:3}" ||
    fail "$folder/$1/build/$program does not run"
}

# `count TREE PART` prints the instructions of a tick without the controller's exchange.
count() {
  local ticks=3000 log=$folder/valgrind.log
  tick "$1" "$2" hurry $ticks valgrind --tool=callgrind --callgrind-out-file=/dev/null --log-file="$log" \
    --collect-atstart=no --toggle-collect='haptic::HapticLoop::tick(long, long)' \
    --toggle-collect='*TimedController::exchange*' >/dev/null
  awk -v ticks=$ticks '/Collected :/ { printf "%.0f\n", $NF / ticks }' "$log"
}

# `times PART PACE TICKS` prints before and now of each turn; every other turn begins with now.
times() {
  local turn before now
  for ((turn = 0; turn < turns; ++turn)); do
    ((turn % 2)) || before=$(tick "$earlier" "$@")
    now=$(tick now "$@")
    ((turn % 2 == 0)) || before=$(tick "$earlier" "$@")
    echo "$before $now"
  done
}

# `summary UNIT` reads lines of before and now.
summary() {
  awk -v unit="$1" '
    function at(values, share,    i, place, below) {
      place = 1 + share * (NR - 1); below = int(place); i = below < NR ? below + 1 : below
      return values[below] + (place - below) * (values[i] - values[below])
    }
    function sort(values,    i, j, value) {
      for (i = 2; i <= NR; ++i) {
        value = values[i]
        for (j = i - 1; j > 0 && values[j] > value; --j) values[j + 1] = values[j]
        values[j + 1] = value
      }
    }
    { before[NR] = $1; now[NR] = $2; ratio[NR] = $2 / $1 }
    END {
      sort(before); sort(now); sort(ratio)
      printf "%.0f %s before, %.0f now, %.3f times", at(before, 0.5), unit, at(now, 0.5), at(ratio, 0.5)
      if (NR > 1) printf " (%.3f to %.3f)", at(ratio, 0.25), at(ratio, 0.75)
      print ""
    }'
}

for part in own touching; do
  if command -v valgrind >/dev/null; then
    printf '%s: ' $part
    { count "$earlier" $part && count now $part; } | paste -s -d ' ' | summary instructions
  fi
  printf '%s, hurry: ' $part
  times $part hurry 5000 | summary ns
  printf '%s, wait: ' $part
  times $part wait 700 | summary ns
done
