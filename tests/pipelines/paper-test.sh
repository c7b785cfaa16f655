#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# paper.sh draws the paper's figures from what was measured: of a clip whose motion is known, that motion.

source "$(dirname "$0")/support.sh"
[ -x "$build/pipelines/motion-log" ] || skip "the program motion-log is not built"

clip "$work/clip.mkv" 352 288 30 3 uniform:60,-30
"$root/pipelines/paper/paper.sh" --video "$work/clip.mkv" --hand hold:0.2,0.1,0 "$work/figures" >"$work/output" 2>&1 ||
  { cat "$work/output"; exit 1; }

# 60 px/s to the right and 30 px/s up at 30 pictures a second, of the pair that seemed to move most.
displacement() {
  sed -n 's/.*displacement is (\(.*\), \(.*\)) px.*/\1 \2/p' "$work/output" |
    awk '{ found = 1; if ($1 < 1.9 || $1 > 2.1 || $2 < -1.1 || $2 > -0.9) exit 1 } END { exit !found }'
}
promise "the mean displacement is that of the clip" displacement
for figure in features flow trace; do
  promise "$figure.png shows the motion in orange" has_colour "$work/figures/$figure.png" 'e6 9f 00' 100
done
for figure in gain trace; do
  promise "$figure.png shows the force in blue" has_colour "$work/figures/$figure.png" '00 72 b2' 100
done
promise "mapping.png shows the pointer events in black" has_colour "$work/figures/mapping.png" '00 00 00' 100
promise "the picture itself is behind the features" has_colour "$work/figures/features.png" '80 80 80' 20
# 2/π · arctan(0.01 · 67) N.
promise "the largest force is equation (5)'s" grep -qE 'force at most 0\.3[78] N' "$work/output"

! "$root/pipelines/paper/paper.sh" --video "$work/none.mkv" "$work/figures" 2>"$work/output" || exit 1
promise "a video that is not there is named" grep -q "there is no file '$work/none.mkv'" "$work/output"
