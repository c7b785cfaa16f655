#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Measures what a tick of the loop costs, divided by its cost at an earlier commit: the loop's own part, and the same with
# a hand that touches. Both commits are built alike and take turns, so that a machine that slows down slows both. The least
# median of all turns counts, which the program knows to 6 %. Nothing else should run meanwhile.
#
# Usage: tests/measure/benchmarks/tick-cost.sh [--turns N] [--seconds S] COMMIT
#   COMMIT        one that has tests/measure/benchmarks/hapticsink-loop.cpp
#   --turns N     how often each of the two is measured (8)
#   --seconds S   how long each of the three parts of a measurement lasts (3)
#
# Builds in build-tick-cost/, where a second run finds both.

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

turns=8 seconds=3
read_options 'turns= seconds=' "$@"
[ ${#inputs[@]} = 1 ] || fail "give one commit to compare with; see --help"
earlier=$(git -C "$root" rev-parse --verify --quiet "${inputs[0]}^{commit}") || fail "'${inputs[0]}' is no commit; see git log"
folder=$root/build-tick-cost program=tests/measure/benchmarks/hapticsink-loop

# `compile TREE` builds the program of $folder/TREE.
compile() {
  local tree=$folder/$1
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

# The program fails if a tick was late, which does not matter here.
for ((turn = 0; turn < turns; ++turn)); do
  for tree in "$earlier" now; do
    { "$folder/$tree/build/$program" "$seconds" || true; } |
      sed -nE "s/^(own part|touching) +p50 +([0-9.]+) us.*/\\1 $tree,\\2/p"
  done
done | awk -F , -v earlier="$earlier" '
  !($1 in least) || $2 < least[$1] { least[$1] = $2 }
  function compare(part, before, now) {
    before = least[part " " earlier]; now = least[part " now"]
    if (!before || !now) exit 1
    printf "%s: %.1f us before, %.1f us now, %.2f times\n", part, before, now, now / before
  }
  END { compare("own part"); compare("touching") }' || fail "hapticsink-loop prints no times; run $folder/now/build/$program"
