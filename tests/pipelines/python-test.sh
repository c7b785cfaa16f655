#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The example in Python moves the pointer and prints the motion that is there.

source "$(dirname "$0")/support.sh"
/usr/bin/python3 -c 'import gi; gi.require_version("Gst", "1.0"); from gi.repository import Gst' 2>/dev/null ||
  skip "Python does not find GStreamer (packages python3-gi and gir1.2-gstreamer-1.0)"

clip "$work/clip.mkv" 352 288 30 3 uniform:60,-30
"$root/pipelines/examples/follow.py" "$work/clip.mkv" >"$work/output" 2>&1 || { cat "$work/output"; exit 1; }

true_motion() {
  awk '/px\/s/ { n++; if ($5 < 57 || $5 > 63 || $6 < -33 || $6 > -27) { print; exit bad = 1 } } END { exit bad || n < 60 }' "$work/output"
}
promise "every frame has the motion of the clip" true_motion
promise "wherever the pointer is" test "$(sed -n 's/.* at \(.*\):.*/\1/p' "$work/output" | sort -u | wc -l)" -gt 10
promise "the counters of the sink are read" grep -q '^The sink says: hapticsink-stats, ticks=(guint64)[1-9]' "$work/output"

refused() { ! "$root/pipelines/examples/follow.py" "$1" >"$work/output" 2>&1; }
promise "a file that is not there is refused" refused "$work/none.mkv"
promise "and named" grep -q "there is no file '$work/none.mkv'" "$work/output"
promise "a file that is no video ends with an error" refused "$0"
