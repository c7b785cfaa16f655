# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034,SC2154 # $processor_time is for its users, $root theirs
# How the tests of a build folder are run. To be sourced with $root set.

# `run_and_repeat LOGS PROCESSES COMMAND...`: COMMAND is `meson test` with its options, which writes into the folder LOGS;
# so many tests at once. Each case and each script that failed is repeated alone, and the file LOGS/alone names those that
# passed then. Returns 1 if the run went wrong in another way than by failed tests.
run_and_repeat() {
  local logs=$1 processes=$2 status=0 failures name case
  shift 2
  rm -f "$logs"/testlog*.json "$logs/alone"
  "$@" --num-processes "$processes" </dev/null || status=$?
  failures=$(python3 "$root/tests/summary.py" failed "$logs/testlog.json")
  while IFS=$'\t' read -r name case; do
    [ -n "$name" ] || continue
    printf '\n== Alone: %s %s\n' "$name" "$case"
    # Of a case alone only the first shard would run anything.
    if "$@" --num-processes 1 --logbase testlog-alone \
      ${case:+"--wrapper=env -u GTEST_TOTAL_SHARDS -u GTEST_SHARD_INDEX" "--test-args=--gtest_filter=$case"} "$name" </dev/null; then
      printf '%s\t%s\n' "$name" "$case" >>"$logs/alone"
    fi
  done <<<"$failures"
  # Its status is the number of failed tests.
  [ "$status" = "$(cut -f 1 <<<"$failures" | sort -u | grep -c .)" ]
}

# Sets $processor_time to the seconds of processor time that the commands of this shell have used. Not to be called in a
# subshell, which counts its own.
count_processor_time() {
  local times
  times=$(mktemp)
  times >"$times"
  processor_time=$(awk 'NR == 2 { gsub("s", ""); split($1 "m" $2, part, "m"); printf "%d", part[1] * 60 + part[2] + part[3] * 60 + part[4] }' "$times")
  rm -f "$times"
}
