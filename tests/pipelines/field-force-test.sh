#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A hand feels the same from the coded field of the whole frame as from the tracker under it: rms of the difference
# of both forces, of a full force of 1 N. FIELD_CLIPS may name a folder with other videos (*.mp4).

source "$(dirname "$0")/support.sh"
use_elements roitracker velocityavg motionfield hapticconvert hapticsink

# `force CLIP HAND LOG ELEMENTS`: what a hand resting there feels. The sink begins 2 s late, and ELEMENTS have a queue
# that is large enough for all: a busy machine delays the measurement and not the force.
force() {
  local clip=$1 hand=$2 log=$3
  shift 3
  gst-launch-1.0 -q filesrc "location=$clip" ! decodebin ! videoconvert ! "$@" \
    ! hapticsink device=sim "sim-hand=hold:$hand,0" "log-location=$log" ts-offset=2000000000
}
queue=(queue max-size-buffers=0 max-size-bytes=0 max-size-time=0)

# Both at once, which share the video's time. What is measured before the queue cannot ask the hand for its place.
compare() {
  local clip=$1 hand=$2 pointer
  pointer=$(awk -F, '{ print "pointer-x=" (1 + $1) / 2, "pointer-y=" (1 - $2) / 2 }' <<<"$hand")
  # shellcheck disable=SC2086 # two words
  force "$clip" "$hand" "$work/direct.csv" roitracker pointer-source=property $pointer ! velocityavg ! "${queue[@]}" &
  force "$clip" "$hand" "$work/field.csv" motionfield ! hapticconvert ! meta/x-klv ! "${queue[@]}" ! hapticconvert || return 1
  wait $! || return 1
  # The force fades for a moment where the machine ran no tick for more than 20 ms (128 in hold).
  awk -F, '
    FNR == 1 { for (i = 1; i <= NF; i++) if ($i == "hold") hold = i; next }
    { t = int($1 * 1000 + 0.5) }
    int($hold / 128) % 2 { for (i = 0; i < 400; i++) fades[t + i] = 1 }
    NR == FNR { x[t] = $8; y[t] = $9; next }
    { fx[t] = $8; fy[t] = $9 }
    END {
      for (t in fx)
        if (t + 0 > 2000 && t in x && !(t in fades)) {
          n++; off += (fx[t] - x[t]) ^ 2 + (fy[t] - y[t]) ^ 2; felt += x[t] ^ 2 + y[t] ^ 2
        }
      if (!n) exit 1
      off = sqrt(off / n); felt = sqrt(felt / n)
      printf "%.1f %% of the full force apart, where %.1f %% are felt\n", 100 * off, 100 * felt
      exit !(n > 1000 && felt > 0 && off <= 0.05)
    }' "$work/direct.csv" "$work/field.csv"
}

if [ -z "${FIELD_CLIPS:-}" ]; then
  FIELD_CLIPS=$work/clips
  mkdir "$FIELD_CLIPS"
  clip "$FIELD_CLIPS/leaf.mp4" 640 360 30 4 leaf
  clip "$FIELD_CLIPS/halves.mp4" 640 360 30 4 halves:40,-60,-80,20
fi
clips=("$FIELD_CLIPS"/*.mp4)
[ -f "${clips[0]}" ] || skip "there are no videos in the folder '$FIELD_CLIPS'"
for clip in "${clips[@]}"; do
  for hand in ${FIELD_HANDS:-0.2,0.3}; do
    promise "${clip##*/} at $hand" compare "$clip" "$hand"
  done
done
