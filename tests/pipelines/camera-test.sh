#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A live source is felt with and without a window, until Ctrl-C.

source "$(dirname "$0")/support.sh"

# The test picture moves to the left at 60 px/s.
read -r fx fy < <(force_of -60 0)
motion_is_felt() {
  promise "the log is sound" sound_log "$1" 1 3
  promise "the force is that of the motion" felt "$1" "$fx" "$fy"
}

promise "the live test picture runs without a window until Ctrl-C" \
  env -u DISPLAY -u WAYLAND_DISPLAY "$interrupt_at" "$work/log.csv" 3.5 \
  "$root/pipelines/camera.sh" --test-source -- device=sim "log-location=$work/log.csv"
motion_is_felt "$work/log.csv"

need_window_system
promise "and with one" in_window_system "$interrupt_at" "$work/window.csv" 3.5 \
  "$root/pipelines/camera.sh" --test-source -- device=sim "log-location=$work/window.csv"
motion_is_felt "$work/window.csv"
