#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# touch-depth.sh and touch-colour.sh: a hand feels the depth and the colours of a film, beside its motion.

source "$(dirname "$0")/support.sh"
draw=$build/pipelines/films/depth-film

# `touch_it SCRIPT HAND OPTION...`: without a window. The log is $work/out/trace.csv.
touch_it() {
  local script=$1 hand=$2
  shift 2
  "$root/pipelines/$script.sh" --no-window --output "$work/out" "$@" -- device=sim "sim-hand=$hand" >"$work/said" ||
    { cat "$work/said"; return 1; }
}
log=$work/out/trace.csv

# A late tick makes a surface softer for as long as it is touched (docs/force.md): to 0.2 N·s/m over the longest tick.
softest() {
  awk -F, '
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    NR > 2 && $at["mono"] - before > longest { longest = $at["mono"] - before }
    { before = $at["mono"] }
    END { print (longest > 0 ? 0.2 / longest : 0) }' "$log"
}

# `rows CONDITION COUNT`: the awk condition holds in so many rows at least. `spring(K, D)` is whether fz is that of so many
# N/m over so many m, within 5 %, or as soft as a late tick makes it; `soft` is what such a tick leaves of 200 N/m.
rows() {
  awk -F, -v "least=$2" -v "softest=$(softest)" '
    function spring(k, d) { return fz > 0.95 * (k < softest ? k : softest) * d && fz < 1.05 * k * d }
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    { time = $1; fx = $8; fz = $10; touch = $at["touch"]; soft = softest < 200 ? softest / 200 : 1 }
    '"$1"' { n++ }
    END { print n + 0 " rows: '"$1"'"; exit n + 0 < least }' "$log"
}

# The rolling ball rests for a moment at 1.25 s, 10 mm above the middle of the workspace at its nearest point, which is
# here. The hand is 7.5 mm above the middle.
write_depth_film "$draw" "$work/scene.mkv" 3
nearest=hold:0.875,-0.844,0.3

# `as_high FROM TO`: at these times the force is that of a spring of 200 N/m from the hand to the true height, or of a
# softer one after a late tick, within 60 mN, which are 0.3 mm.
as_high() {
  "$draw" 3 600 332 >"$work/heights"
  awk -v from="$1" -v to="$2" -v "softest=$(softest)" '
    FNR == 1 { file++ }
    file == 1 { height[FNR - 1] = $2; next }
    FNR == 1 { FS = ","; next }
    $1 > from && $1 < to {
      frame = int($1 * 30); part = $1 * 30 - frame
      depth = height[frame] * (1 - part) + height[frame + 1] * part - $4
      rows++
      soft = softest < 200 ? softest : 200
      off = $10 < soft * depth ? soft * depth - $10 : $10 - 200 * depth
      if (off > worst) worst = off
    }
    END {
      print rows + 0 " rows, off by " worst + 0 " N at most, softest " softest " N/m"
      exit rows < 150 || worst > 0.06
    }' "$work/heights" "$log"
}

promise "a film is touched" touch_it touch-depth $nearest --video "$work/scene.mkv"
promise "to its end" sound_log "$log" 1 2.9
promise "a ball lifts a hand that is pressed upon it, as high as it is" as_high 1.2 1.4
says_how_much() {
  awk -v "softest=$(softest)" '
    /^Force .* N towards the user/ { said = $2 }
    END { exit !(said >= 0.3 * (softest < 200 ? softest / 200 : 1) && said < 0.6) }' "$work/said"
}
promise "the script says how much" says_how_much
promise "and draws it" has_colour "$work/out/trace.png" '00 72 b2' 500

promise "above it, before the wall," touch_it touch-depth hold:0.5,0.85,0.3 --video "$work/scene.mkv" --touch surface
promise "there is nothing" in_log "$log" 'force < 0.001'

# It passes here at 2.5 s.
promise "a ball that passes" touch_it touch-depth hold:0,-0.8,0.24 --video "$work/scene.mkv"
promise "is felt by its shape and its motion at once" rows 'fz > 0.2 * soft && fx < -0.3' 50
promise "with --touch off" touch_it touch-depth hold:0,-0.8,0 --video "$work/scene.mkv" --touch off
promise "by its motion" rows 'fx < -0.3' 100
promise "alone" in_log "$log" 'abs(fz) < 0.001'

ffmpeg -v error -i "$work/scene.mkv" -vf "drawbox=x=640:w=640:h=360:color=black:t=fill:enable='gte(t,1.3)'" \
  -c:v libx264 -qp 4 "$work/lost.mkv" </dev/null
promise "depth that is lost in mid-film" touch_it touch-depth $nearest --video "$work/lost.mkv" --touch surface
promise "is felt until then" rows 'time > 1.1 && time < 1.3 && fz > 0.3 * soft' 80
promise "and then no longer" in_log "$log" 'time < 1.45 || force < 0.001'
promise "without a jolt" smooth "$log" 100
promise "to the end of the film" sound_log "$log" 1 2.9

for coded in mjpeg libx264; do # with luma to 255, and to 235
  ffmpeg -v error -f lavfi -i "color=white:s=320x120:r=30:d=2" -c:v $coded "$work/white.mkv" -y </dev/null
  promise "white depth in $coded" touch_it touch-depth hold:0,0,0.7 --video "$work/white.mkv"
  promise "is high" rows 'touch == 1 && fz > 0.2 * soft' 1000
done

ffmpeg -v error -f lavfi -i "color=black:s=320x240:r=30:d=2,drawbox=x=160:w=160:h=240:color=white:t=fill" \
  -c:v libx264 -qp 4 "$work/halves.mkv" </dev/null
printf '%s\n' '[table]' unit=mm '[entry-1]' colour=#ffffff height=4 stiffness=150 friction=0 \
  '[entry-2]' colour=#000000 height=-4 stiffness=50 friction=0 >"$work/own.ini"
promise "a table says that white is 4 mm high" touch_it touch-colour hold:0.5,0,0 --video "$work/halves.mkv" --table "$work/own.ini"
# shellcheck disable=SC2016 # $4 is awk's
promise "and of 150 N/m" rows 'touch == 1 && spring(150, 0.004 - $4)' 1000
in_a_window() {
  in_window_system "$root/pipelines/touch-colour.sh" --output "$work/out" --video "$work/halves.mkv" \
    --table "$work/own.ini" -- device=sim sim-hand=hold:0.5,0,0 >"$work/said" || { cat "$work/said"; return 1; }
}
if command -v xvfb-run >/dev/null; then
  promise "in a window," in_a_window
  # shellcheck disable=SC2016 # $4 is awk's
  promise "where the height is light, too" rows 'touch == 1 && spring(150, 0.004 - $4)' 1000
fi
promise "black" touch_it touch-colour hold:-0.5,0,0 --video "$work/halves.mkv" --table "$work/own.ini"
promise "is below the hand" in_log "$log" 'force < 0.001'

found_opencv_file aloeGT.png || skip "all of that, but aloeGT.png is not here; run tests/run.sh (package opencv-doc)"
rm "$log"
promise "a still picture is touched until Ctrl-C" "$interrupt_at" "$log" 1 'time >= 4' \
  "$root/pipelines/touch-depth.sh" --still --no-window --output "$work/out" -- device=sim
promise "a leaf lifts the hand" rows 'fz > 0.3 * soft' 200
promise "and between leaves there is nothing" rows 'touch == 0' 1000
