#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Tracks of reliefs in haptic-track: every form gives them back, a part begins anew, heights are drawn, and two tracks are
# compared.
# From the environment, beside that of support.sh: MAKE_RELIEFS, the program beside this file.

source "$(dirname "$0")/support.sh"

# `makes NAME FRAMES CHANGE...`: a track of the moving scene, $work/NAME.klv; see make-reliefs.cpp.
makes() {
  "$MAKE_RELIEFS" "$work/$1.klv" "${@:2}"
}
# `says STATUS TEXT COMMAND...`: the exit status of haptic-track, and what it must say.
says() {
  local status=0 wanted=$1 text=$2
  shift 2
  haptic_track "$@" >"$work/said" 2>&1 || status=$?
  [ "$status" = "$wanted" ] && { [ -z "$text" ] || grep -qF -- "$text" "$work/said"; } && return
  echo "status $status instead of $wanted, or '$text' is missing in:"
  cat "$work/said"
  return 1
}
# Of MPEG-TS it is not 0.
begin_of() {
  sed -n 's/^  time  *\([0-9.]*\) to .*/\1/p' "$work/said"
}
promise "a scene of six seconds" makes scene 180

# ---- convert and cut ----
for form in ts mkv txt; do
  promise "reliefs become .$form" says 0 '' convert "$work/scene.klv" "$work/scene.$form"
  promise "and are known" says 0 'reliefs    180' info "$work/scene.$form"
  promise "with their heights" grep -q 'height  .* mm' "$work/said"
  begin=$(begin_of)
  promise "and the same come back" says 0 '' convert --force "$work/scene.$form" "$work/back.klv"
  promise "for every hand" says 0 'distinguishable  0.0 %' compare --at-most 0 --offset "-$begin" "$work/scene.klv" "$work/back.klv"
done
promise "bare forms keep every bit" says 0 '' convert --force "$work/scene.txt" "$work/back.klv"
promise "of the track" cmp "$work/scene.klv" "$work/back.klv"
for form in hmpg hjif wav ahap; do
  promise "a surface is no motion for .$form" says 1 'this form holds motion' convert "$work/scene.klv" "$work/none.$form"
done
printf 'time,x,y,z,fx,fy,fz\n0,0,0,-0.02,0,0,0\n6,0.01,0,-0.02,0,0,0\n' >"$work/hand.csv"
promise "nor for points under a hand" says 1 'Let hapticsink feel it' convert --hand "$work/hand.csv" "$work/scene.klv" "$work/none.txt"

promise "a part that begins between key fields" says 0 '' cut --from 0.52 --to 1.52 "$work/scene.mkv" "$work/part.txt"
promise "has every relief of its second" says 0 'reliefs    30' info "$work/part.txt"
promise "and no other surface" says 0 'distinguishable  0.0 %' compare --at-most 0 --offset 0.52 --from 0.54 --to 1.5 \
  "$work/scene.klv" "$work/part.txt"
promise "an empty part is refused" says 1 'no sample between these times' cut --from 20 "$work/scene.klv" "$work/none.klv"

# ---- a film with a surface ----
gst-launch-1.0 -q mpegtsmux name=mux ! filesink "location=$work/surface.ts" \
  videotestsrc pattern=ball num-buffers=180 ! video/x-raw,width=320,height=240,framerate=30/1 \
  ! x264enc key-int-max=30 tune=zerolatency ! h264parse ! queue ! mux. \
  filesrc "location=$work/scene.ts" ! tsdemux ! meta/x-klv ! queue ! mux.
promise "reliefs beside a video of MPEG-TS" says 0 'reliefs    180' info "$work/surface.ts"
promise "that begins later" test "$(begin_of)" != 0.000
promise "become a track alone" says 0 '' convert "$work/surface.ts" "$work/surface.klv"
promise "of as many" says 0 'reliefs    180' info "$work/surface.klv"
promise "that begins with the video" test "$(begin_of)" = 0.000

# ---- a film with motion and surface ----
gst-launch-1.0 -q matroskamux name=mux ! filesink "location=$work/film.mkv" \
  videotestsrc pattern=ball num-buffers=180 ! video/x-raw,width=320,height=240,framerate=30/1 ! tee name=t \
  ! queue ! x264enc key-int-max=30 tune=zerolatency ! h264parse ! mux. \
  t. ! queue ! motionfield ! hapticconvert ! text/x-raw ! queue ! mux.subtitle_0 \
  filesrc "location=$work/scene.ts" ! tsdemux ! meta/x-klv ! queue ! hapticconvert ! text/x-raw ! queue ! mux.subtitle_1
promise "a film with both names both" says 0 '(reliefs)' info "$work/film.mkv"
surface=$(sed -n 's/^  another  *\(.*\) (reliefs)$/\1/p' "$work/said")
promise "the motion is the first" grep -q '^  fields  ' "$work/said"
promise "the surface is chosen" says 0 'reliefs    180' info --stream "$surface" "$work/film.mkv"
begin=$(begin_of)
promise "a surface is not compared with a motion" says 1 'is a surface to touch' compare "$work/scene.klv" "$work/film.mkv"
promise "unless the surface is chosen" says 0 'distinguishable  0.0 %' compare --stream "$surface" --at-most 0 \
  --offset "-$begin" "$work/scene.klv" "$work/film.mkv"
promise "a part of the film has the surface" says 0 '' cut --with-video --stream "$surface" --from 1.2 --to 2.9 \
  "$work/film.mkv" "$work/part.mkv"
promise "from key frame to key frame" says 0 'reliefs    60' info "$work/part.mkv"
promise "with the picture" grep -q 'video/x-h264' "$work/said"

# ---- compare ----
makes little 180 scale=1.005
makes more 180 scale=1.1
makes noisy 180 noise=0.3
makes late 180 delay=10
makes empty 30 surface=none
share() {
  haptic_track compare --json "$work/scene.klv" "$work/$1.klv" | python3 -c 'import json, sys; print(json.load(sys.stdin)["distinguishable"])'
}
promise "a scale is told apart the more the larger it is" python3 -c 'import sys
little, more = map(float, sys.argv[1:])
assert little < more and more > 0.5, (little, more)' "$(share little)" "$(share more)"
promise "so is noise" says 1 'were allowed' compare --at-most 10 "$work/scene.klv" "$work/noisy.klv"
promise "and a delay" says 0 ' later than A, which is felt' compare "$work/scene.klv" "$work/late.klv"
promise "at places of mine" says 0 'at 12 places' compare --places 4x3 "$work/scene.klv" "$work/more.klv"
promise "along a hand" says 0 'distinguishable  0.0 %' compare --hand "$work/hand.csv" --at-most 0 "$work/scene.klv" "$work/scene.klv"
promise "that is pressed in, which is felt" grep -q 'felt  *[1-9]' "$work/said"
promise "with a log where its hand was" says 0 'distinguishable' compare "$work/scene.klv" "$work/hand.csv"
promise "no surface at all" says 1 'no relief of this track has a surface' compare "$work/scene.klv" "$work/empty.klv"

# ---- plot ----
if command -v gnuplot >/dev/null; then
  promise "the height is drawn" says 0 '' plot "$work/scene.klv" "$work/height.png"
  promise "in the green of what is touched" has_colour "$work/height.png" '00 9e 73' 500
  promise "at a place" says 0 '' plot --place 0.2,0.7 "$work/scene.klv" "$work/place.png"
  promise "which is another one" test "$(cmp -s "$work/height.png" "$work/place.png" && echo same)" = ''
  promise "under a hand" says 0 '' plot --hand "$work/hand.csv" "$work/scene.klv" "$work/under.png"
  promise "is another one" test "$(cmp -s "$work/height.png" "$work/under.png" && echo same)" = ''
  promise "a comparison is drawn" says 0 '' compare --plot "$work/compared.png" "$work/scene.klv" "$work/more.klv"
  promise "with what is told apart" has_colour "$work/compared.png" '99 99 99' 500
  promise "no surface there" says 1 'never a surface at this place' plot "$work/empty.klv" "$work/none.png"
  promise "a surface does not move" says 1 'only motion fields' plot "$work/scene.klv" "$work/none.gif"
  promise "no place" says 1 'such as 0.5,0.25' plot --place 0.5 "$work/scene.klv" "$work/none.png"
  promise "a place outside" says 1 'such as 0.5,0.25' plot --place 0.5,2 "$work/scene.klv" "$work/none.png"
fi
