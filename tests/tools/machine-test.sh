#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# spidar-check --machine on this machine: the form of what it prints, whatever the verdict.
# Usage: machine-test.sh SPIDAR-CHECK
check=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

complain() {
  echo "FAILED: $1"
  sed 's/^/  | /' "$work/output"
  failed=1
}

# `wants LINE...`: the extended regular expression of each line, in this order.
wants() {
  local number=0 line
  for line; do
    number=$((number + 1))
    sed -n "${number}p" "$work/output" | grep -qE -- "^$line\$" || complain "line $number is not '$line'"
  done
  [ "$(wc -l <"$work/output")" = "$number" ] || complain "there are not $number lines"
}

status=0
"$check" --machine --device sim --seconds 0.3 --report "$work/report" >"$work/output" 2>&1 || status=$?
figures='99\.9 % of the ticks began up to [0-9.]+ ms late, the latest [0-9.]+ ms'
wants 'spidar-check [0-9.]+, libspidar [0-9.]+, .*' 'simulated SPIDAR-G .*' 'real-time priority: (yes|no)' \
  "idle for 0\.3 s: $figures" "[1-9][0-9]* processors busy for 0\.3 s: $figures" \
  'This machine is (not fit for a force|fit for a force|fit for a force with limits): .*\.'
diff "$work/output" "$work/report" || complain 'the report is not what was printed'
unfit=0
grep -q '^This machine is not fit' "$work/output" && unfit=1
[ "$status" = "$unfit" ] || complain "status $status"

for seconds in 0 nan 4000; do
  status=0
  "$check" --machine --device sim --seconds "$seconds" >"$work/output" 2>&1 || status=$?
  [ "$status" = 2 ] || complain "--seconds $seconds: status $status instead of 2"
done
[ "$failed" = 0 ]
