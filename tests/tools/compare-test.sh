#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# haptic-track compare as a person uses it: logs of different rates and lengths, tracks, fields, and what is no log.
# Usage: compare-test.sh HAPTIC-TRACK DATA-FOLDER

tool=$(realpath "$1") data=$(realpath "$2")
source "$(dirname "$0")/../support/promise.sh"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export GST_REGISTRY=$work/registry.bin

# `log FILE RATE SECONDS DELAY GAIN`: a force that swings at 0.7 and 1.9 Hz, the hand at the left.
log() {
  awk -v "rate=$2" -v "seconds=$3" -v "delay=$4" -v "gain=$5" 'BEGIN {
    print "time,x,y,z,fx,fy,fz"
    for (i = 0; i <= seconds * rate; ++i)
      printf "%.6f,-0.02,0,0,%.6f,%.6f,0\n", i / rate, gain * 0.5 * sin(4.4 * (i / rate - delay)),
        gain * 0.3 * sin(11.9 * (i / rate - delay))
  }' >"$work/$1"
}

# `compares STATUS TEXT ARGUMENTS...`: its exit status, and what it must say.
compares() {
  local status=0 wanted=$1 text=$2
  shift 2
  (cd "$work" && "$tool" compare "$@") >"$work/output" 2>&1 || status=$?
  [ "$status" = "$wanted" ] && grep -qF -- "$text" "$work/output" && return
  echo "status $status instead of $wanted, or '$text' is missing in:"
  cat "$work/output"
  return 1
}

log a.csv 1000 5 0 1
log slow.csv 60 5 0 1
log late.csv 1000 5 0.03 1
log later.csv 1000 5 0.3 1
log strong.csv 1000 5 0 1.2
log half.csv 1000 2.5 0 1
awk -F, 'BEGIN { OFS = "," } NR > 1 { $1 += 100 } 1' "$work/a.csv" >"$work/elsewhere.csv"
head -n 1 "$work/a.csv" >"$work/empty.csv"
sed '3s/[^,]*$/nothing/' "$work/a.csv" >"$work/no-number.csv"
sed '3s/,[^,]*$//' "$work/a.csv" >"$work/short-row.csv"
sed '3s/^[^,]*/0.5/' "$work/a.csv" >"$work/back.csv"
{ head -n 2 "$work/a.csv"; head -c 100000 /dev/zero | tr '\0' 1; } >"$work/long-line.csv"
awk -F, 'BEGIN { OFS = "," } NR == 3 { $1 = 99999 } 1' "$work/a.csv" | head -n 3 >"$work/days.csv"
cut -d, -f1,5- "$work/a.csv" >"$work/no-hand.csv"

promise 'a log and itself' compares 0 'distinguishable  0.0 %' a.csv a.csv --at-most 0
promise 'another rate' compares 0 'distinguishable  0.0 %' a.csv slow.csv --at-most 0
promise '30 ms of delay are not felt' compares 0 'B is 30 ms later' a.csv late.csv --at-most 0
promise '300 ms are' compares 1 'were allowed' a.csv later.csv --at-most 50
promise 'and are named' compares 0 'B is 300 ms earlier than A, which is felt' later.csv a.csv
promise 'unless they are taken off' compares 0 'shift            none' a.csv later.csv --offset -0.3
promise 'or are said to be none: what differs is felt' compares 1 'shift            none' a.csv later.csv --shift 0 --at-most 50
promise 'a fifth more force' compares 1 'were allowed' a.csv strong.csv --at-most 50
promise 'half of the time' compares 1 'were allowed' a.csv half.csv --at-most 40
promise 'which is nothing in the first half' compares 0 'distinguishable  0.0 %' a.csv half.csv --to 2.5 --at-most 0
promise 'JSON' compares 0 '"distinguishable":0.0' a.csv late.csv --json
promise 'for programs' python3 -c 'import json, sys; assert json.load(open(sys.argv[1]))["shift_ms"] == 30' "$work/output"
promise 'binary and JSON of MPEG' compares 0 'distinguishable  0.0 %' "$data/golden.hmpg" "$data/golden.hjif"
field=$data/golden-field.klv
promise 'fields' compares 0 'at 15 places' "$field" "$field" --at-most 0
promise 'at places of mine' compares 0 'at 63 places' "$field" "$field" --places 9x7
promise 'JSON of places' compares 0 '"seconds"' "$field" "$field" --json --places 9x7
promise 'has all' python3 -c 'import json, sys; assert len(json.load(open(sys.argv[1]))["places"]) == 63' "$work/output"
promise 'along a hand' compares 0 'distinguishable  0.0 %' "$field" "$field" --hand a.csv
promise 'a log feels fields where its hand was' compares 0 'distinguishable' "$field" a.csv
if command -v gnuplot >/dev/null; then
  promise 'a plot' compares 0 'distinguishable' a.csv strong.csv --plot plot.png
  promise 'is a picture' grep -q PNG "$work/plot.png"
  promise 'that stays' compares 1 'exists' a.csv strong.csv --plot plot.png
  promise 'without --force' compares 0 'distinguishable' a.csv strong.csv --plot plot.png --force
fi
promise 'no common time' compares 1 'no time in common' a.csv elsewhere.csv
promise 'an empty log' compares 1 'there is no force' a.csv empty.csv
promise 'an empty part' compares 1 'there is no force' a.csv a.csv --from 7
promise 'no number' compares 1 'line 3: there is no number' a.csv no-number.csv
promise 'a short row' compares 1 'line 3: columns are missing' a.csv short-row.csv
promise 'time that goes back' compares 1 'line 4: the time goes back' a.csv back.csv
promise 'an endless line' compares 1 'line 3: the line is too long' a.csv long-line.csv
promise 'a day' compares 1 'longer than 4 hours' a.csv days.csv
promise 'no hand' compares 1 'there is no hand' "$field" no-hand.csv
promise 'no place to choose' compares 1 'Leave out --places' a.csv a.csv --places 3x3
promise 'two places' compares 1 'given twice' "$field" "$field" --places 3x3 --hand a.csv
promise 'no grid' compares 1 'such as 0.5,0.25 or 5x3' "$field" "$field" --places 5
promise 'no track' compares 1 'this is no haptic track' a.csv "$(realpath "$0")"
promise 'no file' compares 1 'there is no such file' a.csv nowhere.csv
promise 'one file' compares 1 'needs two files' a.csv
promise 'no percentage' compares 1 'from 0 to 100' a.csv a.csv --at-most half
