#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# haptic-study.sh weighs the answers (equation 6), and draws them.

source "$(dirname "$0")/support.sh"
study=$root/pipelines/study/haptic-study.sh

cat >"$work/known.csv" <<'CSV'
session,time,participant,video,round,force,interactivity,sensitivity,reality
a,t,p1,v,1,yes,5,4,4
a,t,p1,v,2,no,2,3,3
b,t,p2,v,1,no,1,2,4
b,t,p2,v,2,yes,4,4,3
CSV
"$study" report "$work/known.csv" "$work/figure.png" >"$work/report"
promise "the report counts" grep -q '^2 sessions, 0 of them broken off, 2 participants$' "$work/report"
promise "and weighs: 5 and 4 with force are 4.50" \
  grep -qE '^interactivity +with +2 +0 +0 +0 +1 +1 +4\.50$' "$work/report"
promise "2 and 1 without are 1.50" grep -qE '^interactivity +without +2 +1 +1 +0 +0 +0 +1\.50$' "$work/report"
promise "the figure shows both" has_colour "$work/figure.png" '00 72 b2' 5000

echo 'b,t,p2,v,2,yes,4,6,3' >>"$work/known.csv"
refused() { ! "$study" report "$work/known.csv" >"$work/report" 2>&1; }
promise "a damaged file is refused" refused
promise "and the line is named" grep -q 'line 6 is not an answer' "$work/report"
