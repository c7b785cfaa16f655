#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# demo.sh leaves a trace, its picture and a summary, from a file and from a live source. camera.sh is felt with and
# without a window.

source "$(dirname "$0")/support.sh"

# `results FOLDER SECONDS`
results() {
  promise "the log is sound" sound_log "$1/trace.csv" 1 "$2"
  promise "the summary counts the frames" grep -qE '^Frames +[1-9][0-9]*: [1-9]' "$1/output"
  promise "the points" grep -qE '^Points +[1-9][0-9.]* in' "$1/output"
  promise "the force" grep -qE '^Force +x -?[0-9.]+ to' "$1/output"
  promise "the timing of the loop" grep -qE '^1 kHz loop +[1-9][0-9]* ticks' "$1/output"
}

run_demo() {
  local output=$1
  shift
  mkdir -p "$output"
  "$root/pipelines/demo.sh" --output "$output" "$@" >"$output/output" 2>&1 || { cat "$output/output"; return 1; }
}

folder="$work/a folder; with 'odd \"name"
mkdir "$folder"
clip "$work/clip.mkv" 352 288 30 3 uniform:-30,-100
mv "$work/clip.mkv" "$folder/a \"clip\"!.mkv"
promise "demo.sh plays a file" run_demo "$folder/out" --video "$folder/a \"clip\"!.mkv"
results "$folder/out" 2
promise "the picture of the trace shows the velocity in orange" has_colour "$folder/out/trace.png" 'e6 9f 00' 500
promise "and the force in blue" has_colour "$folder/out/trace.png" '00 72 b2' 500
read -r fx fy < <(force_of -30 -100)
promise "the force is that of the motion" felt "$folder/out/trace.csv" "$fx" "$fy"

spoilt() { ! run_demo "$folder/out" --video "$work/notes.txt"; }
echo 'no film' >"$work/notes.txt"
promise "demo.sh refuses what is no film" spoilt
promise "and leaves the last log" sound_log "$folder/out/trace.csv" 1 2

promise "demo.sh plays a live source for the seconds given" \
  run_demo "$work/live" --camera test --seconds 2
results "$work/live" 0.1
promise "with a picture of its trace" test -s "$work/live/trace.png"

promise "demo.sh goes on without a display" \
  env -u DISPLAY -u WAYLAND_DISPLAY "$root/pipelines/demo.sh" --show --camera test --seconds 1 --output "$work/none"
if command -v xvfb-run >/dev/null; then
  promise "demo.sh shows a window" \
    in_window_system "$root/pipelines/demo.sh" --show --camera test --seconds 2 --output "$work/window"
  promise "its log is sound" sound_log "$work/window/trace.csv" 1 0.1
fi

# Ctrl-C reaches all of the foreground: demo.sh and gst-launch.
stopped_early() {
  "$interrupt_at" "$work/stopped/trace.csv" 1 'time >= 1' "$root/pipelines/demo.sh" --camera test --output "$work/stopped" >"$work/stopped.txt" 2>&1
}
promise "Ctrl-C ends demo.sh early without an error" stopped_early
promise "with a summary all the same" grep -qE '^Files .*trace.png' "$work/stopped.txt"

# The test picture moves to the left at 60 px/s. It is live until half a second of that force was felt.
read -r fx fy < <(force_of -60 0)
motion_is_felt() {
  promise "the log is sound" sound_log "$1" 1 0.5
  promise "the force is that of the motion" felt "$1" "$fx" "$fy"
}
promise "camera.sh runs without a window until Ctrl-C" \
  env -u DISPLAY -u WAYLAND_DISPLAY "$interrupt_at" "$work/log.csv" 500 "fx <= $fx + 0.02" \
  "$root/pipelines/camera.sh" --test-source -- device=sim "log-location=$work/log.csv"
motion_is_felt "$work/log.csv"

need_window_system
promise "and with one" in_window_system "$interrupt_at" "$work/window.csv" 500 "fx <= $fx + 0.02" \
  "$root/pipelines/camera.sh" --test-source -- device=sim "log-location=$work/window.csv"
motion_is_felt "$work/window.csv"
