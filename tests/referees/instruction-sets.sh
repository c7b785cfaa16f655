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
unit=${FEELING_WIND_BUILD:-$root/build-tests}/tests/unit/unit-vision
emulator=qemu-x86_64
command -v $emulator >/dev/null || skip "$emulator is not installed (qemu-user)"

[ -x "$unit" ] || fail "'$unit' is not built; run tests/run.sh"
GTEST_FILTER=$(cases_of "${vector_tests[@]}")-$vector_repetitions
export GTEST_FILTER

# `run_on PROCESSOR BEST` fails if the best instruction set that Highway finds there is not BEST.
run_on() {
  local processor=$1 best
  # The names of these tests end with every instruction set, the best first.
  best=$($emulator -cpu "$processor" "$unit-motion-models" --gtest_list_tests 2>/dev/null |
    sed -n '\|^ .*/\([A-Z0-9]*\)\( .*\)\?$|{s||\1|p;q}')
  [ "$best" = "$2" ] || fail "the best instruction set on $processor is '$best', not $2"
  judge $emulator -cpu "$processor" "$unit-motion-models"
  judge $emulator -cpu "$processor" "$unit"
}

run_on Conroe SSSE3
run_on Haswell AVX2
[ $failed = no ]
