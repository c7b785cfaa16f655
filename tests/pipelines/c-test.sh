#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The example in C prints the motion under the pointer.
# Usage: c-test.sh EXAMPLE

source "$(dirname "$0")/support.sh"

clip "$work/clip.mkv" 352 288 30 2 uniform:60,-30
"$1" "$work/clip.mkv" 0.3 0.6 >"$work/output" 2>&1 || { cat "$work/output"; exit 1; }

true_motion() {
  awk '/px\/s/ { n++; if ($2 < 57 || $2 > 63 || $3 < -33 || $3 > -27) { print; exit bad = 1 } } END { exit bad || n < 40 }' "$work/output"
}
promise "every frame has the motion of the clip" true_motion
refused() { ! "$1" "$2" >"$work/output" 2>&1; }
promise "a file that is not there is refused" refused "$1" "$work/none.mkv"
promise "with a reason" grep -qi 'could not open\|not found\|no such file' "$work/output"
