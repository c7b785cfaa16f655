#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Ctrl-C lets the force fade out and leaves a complete log.

source "$(dirname "$0")/support.sh"

clip "$work/clip.mkv" 352 288 30 10 uniform:0,-100
promise "Ctrl-C ends a playing video without an error" "$interrupt_at" "$work/log.csv" 2.5 \
  "$root/pipelines/play-file.sh" "$work/clip.mkv" -- device=sim "log-location=$work/log.csv"
promise "its log is sound" sound_log "$work/log.csv" 1 2
ends_without_force() {
  tail -n 1 "$work/log.csv" | awk -F, '{ exit !(NF >= 22 && $8 == 0 && $9 == 0 && $10 == 0) }'
}
promise "and ends without a force" ends_without_force
