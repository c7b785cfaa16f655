#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# haptic-study.sh plays a video with and without force, asks, and keeps every answer.

source "$(dirname "$0")/support.sh"
study=$root/pipelines/study/haptic-study.sh
clip "$work/clip.mkv" 352 288 30 1 uniform:60,-30

# `session ANSWERS-ON-STDIN OPTION...`
session() {
  local typed=$1
  shift
  printf '%s\n' "$typed" |
    "$study" run --no-window --answers "$work/answers.csv" "$@" "$work/clip.mkv" -- "log-location=$work/trace.csv" \
      >"$work/output" 2>&1
}

promise "a session asks six questions, and again where the answer is none" \
  session $'5\nseven\n4\n3\n\n2\n2\n1' --participant p1 --seed 08
promise "with a seed that may begin with a zero" test "$(grep -c 'value too great' "$work/output")" = 0
promise "the answers are kept" test "$(wc -l <"$work/answers.csv")" = 3
promise "in the order in which they were given" \
  grep -qE '^[0-9T-]+,[0-9TZ:-]+,p1,clip.mkv,1,(yes|no),5,4,3$' "$work/answers.csv"
promise "once with force and once without" \
  test "$(cut -d, -f6 "$work/answers.csv" | sort | tr '\n' ' ')" = 'force no yes '

# The last round's log: force only if it was the one with force.
felt=$(tail -n 1 "$work/answers.csv" | cut -d, -f6)
strongest=$(awk -F, 'NR > 1 { f = sqrt($8 ^ 2 + $9 ^ 2); if (f > most) most = f } END { printf "%.3f", most }' "$work/trace.csv")
case $felt in
yes) promise "with force it is felt" awk -v f="$strongest" 'BEGIN { exit !(f > 0.1) }' ;;
no) promise "without force nothing is felt" awk -v f="$strongest" 'BEGIN { exit !(f == 0) }' ;;
esac

broken_off() { ! session "$@"; }
promise "a session may be broken off" broken_off $'4\n4\n4\n1' --participant p2 --seconds 1
promise "what was answered is kept" grep -qE ',p2,clip.mkv,1,(yes|no),4,4,4$' "$work/answers.csv"
promise "and it says where" grep -q "what was answered before is in '$work/answers.csv'" "$work/output"
