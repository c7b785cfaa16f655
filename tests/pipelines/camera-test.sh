#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A live source is felt with and without a window, until Ctrl-C.

source "$(dirname "$0")/support.sh"

# The test picture moves to the left at 60 px/s.
felt() {
  promise "the log is sound" sound_log "$1" 1 3
  promise "the force is that of the motion" in_log "$1" \
    'time < 1.5 || time > 3 || (abs(fx + 2 / pi * atan(0.6)) <= 0.02 && abs(fy) <= 0.02)' pi=3.141592653589793
}

promise "the live test picture runs without a window until Ctrl-C" \
  env -u DISPLAY -u WAYLAND_DISPLAY timeout --foreground --preserve-status -k 20 -s INT 5 \
  "$root/pipelines/camera.sh" --test-source -- device=sim "log-location=$work/log.csv"
felt "$work/log.csv"

need_window_system
promise "and with one" in_window_system timeout --foreground --preserve-status -k 20 -s INT 5 \
  "$root/pipelines/camera.sh" --test-source -- device=sim "log-location=$work/window.csv"
felt "$work/window.csv"
