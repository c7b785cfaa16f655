#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# wind-film writes a film with its true motion beside it, or a still.

source "$(dirname "$0")/support.sh"
program=$build/pipelines/films/wind-film
[ -x "$program" ] || skip "wind-film is not built (package libcairo2-dev)"
gst-inspect-1.0 --exists x264enc || skip "x264enc is not installed (package gstreamer1.0-plugins-ugly)"

small=(--width 320 --height 180 --rate 30 --duration 1)
for ending in ts mkv; do
  made=$work/film.$ending
  promise "wind-film writes .$ending" "$program" "${small[@]}" "$made"
  promise "complete" test ! -e "$made.part"
  haptic_track info "$made" >"$work/info"
  cat "$work/info"
  promise "with fields of 32 columns and 18 rows" grep -qE '32 *(x|×|columns).*18' "$work/info"
  promise "one for each frame" grep -qE '^ *fields +30$' "$work/info"
  gst-launch-1.0 -m filesrc "location=$made" ! decodebin ! videoconvert ! motionfield ! fakesink >"$work/out"
  promise "that plays" grep -q 'Got EOS from element' "$work/out"
done
promise "the same twice" "$program" "${small[@]}" "$work/again.ts"
promise "to the byte" cmp "$work/film.ts" "$work/again.ts"

promise "it draws a still" "$program" --width 320 --height 180 --at 3 "$work/still.png"
promise "of many greens" has_colour "$work/still.png" '[2-6]. [4-9]. [0-3].' 2000

# `fails_with TEXT ARGUMENT...`: exit status 1 and that text.
fails_with() {
  local text=$1 status=0
  shift
  timeout 60 "$program" "$@" >"$work/said" 2>&1 || status=$?
  cat "$work/said"
  [ "$status" = 1 ] && grep -q -- "$text" "$work/said"
}
promise "a foreign ending is refused" fails_with "must end in .ts, .mkv or .png" "$work/film.avi"
promise "an odd size" fails_with "even numbers" --width 321 "$work/other.ts"
promise "a folder that is not there" fails_with "Give another name" "${small[@]}" "$work/none/film.ts"
disk_is_full() (
  trap '' XFSZ # write() fails instead
  ulimit -f 100
  fails_with "make room on the disk" --width 320 --height 180 --duration 20 "$work/other.ts"
)
promise "a disk that is full" disk_is_full
promise "an unknown option" fails_with "see --help" --wide "$work/other.ts"
promise "no file is left" test ! -e "$work/other.ts" -a ! -e "$work/other.ts.part"
