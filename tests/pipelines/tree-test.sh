#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# tree.avi claims 15 pictures a second and shows two or three: its velocities must come from its time
# stamps.

source "$(dirname "$0")/support.sh"
tree=$(found_opencv_file tree.avi) ||
  skip "tree.avi is not here; ./tests/run.sh fetches it"

# As fast as it decodes, with one message per picture.
gst-launch-1.0 -m filesrc "location=$tree" ! decodebin ! videoconvert ! roitracker \
  ! velocityavg post-messages=true ! fakesink >"$work/messages"

# pts, interval (ns), vx, vy, confidence of each picture.
sed -n 's/.*(element): haptic-motion, pts=(guint64)\([0-9]*\), interval=(guint64)\([0-9]*\), vx=(double)\([^,]*\), vy=(double)\([^,]*\),.* confidence=(double)\([^,]*\),.*/\1 \2 \3 \4 \5/p' \
  "$work/messages" >"$work/motion"

promise "each picture has one measurement" test "$(wc -l <"$work/motion")" = 68
true_intervals() {
  awk 'NR > 1 && $5 > 0 && ($2 != $1 - before || $2 < 0.3e9 || $2 > 0.8e9) { print; bad = 1 }
    { before = $1 } END { exit bad }' "$work/motion"
}
promise "over the interval of its time stamps" true_intervals
plausible_velocities() {
  awk '$5 > 0 { count++; speed = sqrt($3 ^ 2 + $4 ^ 2); moved = speed * $2 / 1e9
      if (moved > 16) { print; bad = 1 } if (moved > 0.2) moving++ }
    END { print count " measured, " moving " moving"; exit bad || count < 40 || moving < 10 }' "$work/motion"
}
promise "leaves move by some pixels from picture to picture, not more" plausible_velocities
