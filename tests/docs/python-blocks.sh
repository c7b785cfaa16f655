#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs the ```python blocks of docs/python.md and docs/tutorial.md, each as a program beside an in.mp4 of known motion,
# without a window. Each must succeed and find the motion, of in.mp4 or of the tutorial's test picture: it prints it for
# most frames, or saves a plot.
#
# Usage: python-blocks.sh playing | other
#   playing  the blocks that play the video in real time
#   other    all other blocks

source "$(dirname "$0")/../pipelines/support.sh"
for module in gi numpy matplotlib; do
  /usr/bin/python3 -c "import $module" 2>/dev/null || skip "Python has no module $module (package python3-$module)"
done
/usr/bin/python3 -c 'import gi; gi.require_version("GstVideo", "1.0")' 2>/dev/null ||
  skip "Python does not find GstVideo (package gir1.2-gst-plugins-base-1.0)"

cd "$work"
clip in.mp4 352 288 30 2 uniform:40,-20
awk '/^```python/ { n++; inside = 1; next } /^```/ { inside = 0 } inside { print >"block-" n ".py" }' \
  "$root"/docs/{python,tutorial}.md

# At least so many lines have the motion of the clip.
true_motion() {
  local right
  right=$(grep -cE '(^|[ :])((39|40|41) -(19|20|21)|-60 0) px/s' output) || true
  [ "$right" -ge "$1" ] || { echo "$right lines have it, of:"; tail -n 20 output; return 1; }
}

run_block() {
  MPLBACKEND=Agg timeout 120 /usr/bin/python3 "$1" >output 2>&1 || { cat output; return 1; }
}

count=0
for block in block-*.py; do
  kind=other
  ! grep -qE 'clocksync|drop=true|hapticsink' "$block" || kind=playing
  [ $kind = "${1:-playing}" ] || continue
  count=$((count + 1))
  promise "$block runs" run_block "$block"
  if grep -q savefig "$block"; then
    promise "$block draws" test -s "$(sed -n 's/.*savefig("\(.*\)").*/\1/p' "$block")"
  else
    promise "$block finds the motion" true_motion 40
  fi
done
promise "there are blocks" test "$count" -ge 2
