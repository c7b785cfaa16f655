#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# With a window beside it the same force is felt.

source "$(dirname "$0")/support.sh"
need_window_system

clip "$work/clip.mkv" 352 288 30 4 uniform:0,-100
promise "a clip plays to its end beside a window" in_window_system \
  "$root/pipelines/play-file-with-display.sh" "$work/clip.mkv" \
  -- device=sim "log-location=$work/log.csv"
promise "its log is sound" sound_log "$work/log.csv" 1 4
promise "its force is that of the motion" felt "$work/log.csv" 0 0.5
