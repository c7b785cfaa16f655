#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# spidar-check as a person uses it, with the simulated device.
# Usage: check-test.sh SPIDAR-CHECK
check=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

# `expect STATUS COMMAND...`; what it prints is kept for `says`.
expect() {
  local status=0 wanted=$1
  shift
  "$@" >"$work/output" 2>&1 </dev/null || status=$?
  [ "$status" = "$wanted" ] || complain "$*: status $status instead of $wanted"
}

says() {
  local text
  for text; do
    grep -qE -- "$text" "$work/output" || complain "'$text' is missing"
  done
}

# Of what was printed last, no promise is listed twice.
lists_once() {
  local twice
  twice=$(sed -nE 's/^(pass|FAIL|not testable) +([^:]*):.*/\2/p' "$work/output" | sort | uniq -d)
  [ -z "$twice" ] || complain "listed twice: $twice"
}

complain() {
  echo "FAILED: $1"
  sed 's/^/  | /' "$work/output"
  failed=1
}

expect 0 "$check" --help
says 'Exit status' '--report' '--ask'
expect 2 "$check" --colour
expect 2 "$check" more
expect 2 "$check" --device serial --yes
says "'serial' is not known"
expect 2 "$check" --device sim --force 0
says '0.05 to 1 N'
expect 2 "$check" --device sim --force nan
expect 2 "$check" --device sim --force 1.5

expect 0 "$check" --device sim --yes --report "$work/report"
says '^spidar-check [0-9.]+, libspidar [0-9.]+, ' '^simulated SPIDAR-G' \
  '^pass +the device answers: 500 of 500 exchanges' \
  '^pass +the pose is known' \
  '^pass +the force is the commanded one: 0.20 N' \
  '^pass +the grip goes where the force points' \
  '^pass +a number that is not finite counts as zero' \
  '^pass +the tension of each string is within the limits' \
  '^pass +closing the device leaves minimum tension' \
  '^not testable +the program is killed or crashes: a simulated' \
  '^geometry spidar-g6x3r, dac-limit 4095' '^volts-per-newton( [-0-9.]+){8}$' \
  '^[0-9]+ pass, 0 fail, [0-9]+ not testable$'
lists_once
diff "$work/output" "$work/report" || complain 'the report is not what was printed'

# Every promise of the safety page is named: the limits, and the events of the table.
safety=$(dirname "$0")/../../docs/safety.md
promises() {
  sed -n '/^## What limits/,/^## /s/^\* \([^:]*\):.*/\1/p' "$safety"
  sed -n '/^| event |/,/^$/s/^| \([^|]*\) |.*/\1/p' "$safety" | sed '1d; s/ *([^)]*)//; s/`//g'
}
[ "$(promises | wc -l)" -gt 15 ] || complain 'the promises of docs/safety.md are not found'
while IFS= read -r promise; do
  grep -qiF -- "$promise" "$work/report" ||
    complain "docs/safety.md promises '$promise': add it to spidar/tools/spidar-check.cpp, with a check or the reason why there is none"
done < <(promises)

# The report has no path into the home folder.
expect 1 env HOME="$work" "$check" --device sim --geometry "$work/none.ini" --yes
says ' .~/none.ini|file ~/none.ini'

# Nobody answers: it does not pull.
expect 0 "$check" --device sim
says 'Press Enter when you are ready' 'the force is the commanded one: it may not pull'
lists_once

expect 2 "$check" --device sim --yes --report "$work/none/report"
says 'cannot be written'

# A hand that moves when it is asked to: right, up, towards.
printf '%s\n' 0,0,0,0 0.7,0,0,0 0.9,0.8,0,0 1.5,0.8,0.8,0 2.2,0.8,0.8,0.8 >"$work/hand"
printf '\n\n\nn\n' >"$work/answers"
if ! "$check" --device sim --ask --sim-hand "file:$work/hand" <"$work/answers" >"$work/output" 2>&1; then
  complain 'the pose follows the hand'
fi
says '^pass +the pose follows the hand to the right .* x \+8' '^pass +the pose follows the hand up .* y \+8' \
  '^pass +the pose follows the hand towards you .* z \+8'
# A hand that goes the other way.
printf '%s\n' 0,0,0,0 0.7,0,0,0 0.9,-0.8,0,0 1.5,-0.8,0.8,0 2.2,-0.8,0.8,0.8 >"$work/hand"
status=0
"$check" --device sim --ask --sim-hand "file:$work/hand" <"$work/answers" >"$work/output" 2>&1 || status=$?
[ "$status" = 1 ] || complain "status $status instead of 1"
says '^FAIL +the pose follows the hand to the right .* x -8.*spidar-calibrate'
[ "$failed" = 0 ]
