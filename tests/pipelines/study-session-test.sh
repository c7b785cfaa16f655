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

# `last_round FELT CONDITION`: the last round was the one with (yes) or without force, and so was its log.
last_round() {
  [ "$(tail -n 1 "$work/answers.csv" | cut -d, -f6)" = "$1" ] &&
    awk -F, "NR > 1 { f = sqrt(\$8 ^ 2 + \$9 ^ 2); if (f > most) most = f } END { print most; exit !(NR > 1 && most $2) }" "$work/trace.csv"
}
promise "with force it is felt" last_round yes '> 0.1'
promise "another seed gives another order" session $'4\n4\n4\n4\n4\n4' --participant p0 --seed 1
promise "and without force nothing is felt" last_round no '== 0'

broken_off() { ! session "$@"; }
promise "a session may be broken off" broken_off $'4\n4\n4\n1' --participant p2 --seconds 1
promise "what was answered is kept" grep -qE ',p2,clip.mkv,1,(yes|no),4,4,4$' "$work/answers.csv"
promise "and it says where" grep -q "what was answered before is in '$work/answers.csv'" "$work/output"
