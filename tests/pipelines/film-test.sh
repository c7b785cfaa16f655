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

promise "it writes the true motion at places" "$program" "${small[@]}" --quality 0 --truth "$work/truth" --places "0.5,0.5 0.7,0.5" "$work/fine.mkv"
promise "which the track of the film agrees with" haptic_track compare --at-most 5 "$work/truth/0.5-0.5.txt" "$work/fine.mkv"
promise "that moves" test "$(grep -cE 'vx=-?[1-9]' "$work/truth/0.5-0.5.txt")" -gt 20
# roitracker clips its square of 27 px about the corner: 13 px of it are left.
promise "at the corner of the square that roitracker has there" "$program" "${small[@]}" --truth "$work/truth" --places "0,0" "$work/again.mkv"
promise "clipped as it is" grep -q 'w=0.040625 h=0.0722222222 ' "$work/truth/0-0.txt"
promise "a finer film has more bytes" test "$(stat -c %s "$work/fine.mkv")" -gt "$(stat -c %s "$work/film.mkv")"
promise "the true motion of the thing in the middle too" "$program" "${small[@]}" --truth "$work/pointed" --truth-of pointed --places "0.7,0.5" "$work/again.mkv"
are_different() { ! cmp -s "$@"; }
promise "is another" are_different "$work/truth/0.7-0.5.txt" "$work/pointed/0.7-0.5.txt"

promise "it writes where points of its things are" "$program" "${small[@]}" --points "$work/points.csv" "$work/again.ts"
in_each_frame() {
  awk -F , '
    FNR == 1 { ok = $0 == "frame,point,kind,x,y,visible"; next }
    { ++count[$3]; ok = ok && $1 == int((FNR - 2) / 200) && $2 == (FNR - 2) % 200 }
    END { exit !(ok && FNR == 1 + 200 * 30 && length(count) == 5 && count["crown-leaf"] == 40 * 30) }' "$1"
}
promise "in each frame" in_each_frame "$work/points.csv"
promise "the same twice" "$program" "${small[@]}" --points "$work/points-again.csv" "$work/again.ts"
promise "to the byte" cmp "$work/points.csv" "$work/points-again.csv"
promise "without another film" cmp "$work/film.ts" "$work/again.ts"

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
leaves_nothing() {
  local process status=0
  "$program" --width 320 --height 180 --duration 600 "$work/long.ts" 2>"$work/said" &
  process=$!
  until [ -e "$work/long.ts.part" ]; do
    kill -0 $process || return 1
    sleep 0.05
  done
  kill -TERM $process
  wait $process || status=$?
  cat "$work/said"
  [ $status = 1 ] && grep -q interrupted "$work/said" && ! compgen -G "$work/long*"
}
promise "an interrupted film leaves nothing" leaves_nothing
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
promise "a place outside" fails_with "write X,Y, each from 0 to 1" "${small[@]}" --truth "$work/none" --places "0.5,1.5" "$work/other.ts"
promise "a truth without places" fails_with "needs places" "${small[@]}" --truth "$work/none" "$work/other.ts"
promise "a truth of nothing" fails_with "square or pointed" --truth-of all "$work/other.ts"
promise "a table in no folder" fails_with "another file to --points" "${small[@]}" --points "$work/none/p.csv" "$work/other.ts"
promise "a quality that x264 does not have" fails_with "0 (without loss) to 51" --quality 52 "$work/other.ts"
promise "no file is left" test ! -e "$work/other.ts" -a ! -e "$work/other.ts.part"
