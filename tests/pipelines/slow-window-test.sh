#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A window that cannot show a film of 4K and 60 frames a second in time makes no gap in the motion: it drops frames
# itself, and the decoder skips none for it.

source "$(dirname "$0")/support.sh"
need_window_system

clip "$work/film.mp4" 3840 2160 60 1 uniform:240,0
need_video "$work/film.mp4"

# Decoder, tracker and window together have one processor.
play() {
  in_window_system taskset -c 0 gst-launch-1.0 -m "${film[@]}" ! roitracker ! "${file_window_branch[@]}" \
    velocityavg ! hapticsink device=sim "log-location=$work/log.csv" >"$work/messages"
}
statistic() {
  sed -nE "s/.*roitracker-stats.*[ ,]$1=\(guint64\)([0-9]+).*/\1/p" "$work/messages"
}
promise "a film of 4K and 60 frames a second plays beside a window" play
seen=$(statistic frames) gaps=$(statistic discontinuities)
echo "$seen frames, $gaps discontinuities"
promise "the tracker sees every frame" test "$seen" = 60
promise "and only the first has none before it" test "$gaps" = 1
