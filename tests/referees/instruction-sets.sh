#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs the unit tests of the vector code on two emulated processors: Conroe, whose best instruction set is SSSE3, and
# Haswell, with AVX2. An instruction that the processor does not have ends a test.
#
# Usage: tests/referees/instruction-sets.sh
#
# Takes the programs from build-tests/ or $FEELING_WIND_BUILD. Without qemu-x86_64 the exit status is 77.

source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$(dirname "$0")/support.sh"

no_options "$@"
unit=${FEELING_WIND_BUILD:-$root/build-tests}/tests/unit/unit
emulator=qemu-x86_64
command -v $emulator >/dev/null || skip "$emulator is not installed (qemu-user)"

programs=(kernels luma-crop pixel-votes motion-models velocity-estimate fast-tracker-limits field-tracker-limits)
for program in "${programs[@]}"; do
  [ -x "$unit-vision-$program" ] || fail "'$unit-vision-$program' is not built; run tests/run.sh"
done

# Statistics over many scenes, and frames without an allocation. An emulator would find nothing more in them.
export GTEST_FILTER='-*.TheSmallestThatExplains*:*.TheFirstFrameAlone*:*.AStationaryMixture*:MotionConfidence.*:*.AfterTheFirst*NothingIsAllocated'

# `run_on PROCESSOR BEST` fails if the best instruction set that Highway finds there is not BEST.
run_on() {
  local processor=$1 best
  # The names of these tests end with every instruction set, the best first.
  best=$($emulator -cpu "$processor" "$unit-vision-motion-models" --gtest_list_tests 2>/dev/null |
    sed -n '\|^ .*/\([A-Z0-9]*\)\( .*\)\?$|{s||\1|p;q}')
  [ "$best" = "$2" ] || fail "the best instruction set on $processor is '$best', not $2"
  for program in "${programs[@]}"; do
    judge $emulator -cpu "$processor" "$unit-vision-$program"
  done
}

run_on Conroe SSSE3
run_on Haswell AVX2
[ $failed = no ]
