#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# pull-character.sh: a hand pulls a character, who returns; the story stays as it is.

source "$(dirname "$0")/support.sh"
/usr/bin/python3 -c 'import gi; gi.require_version("Gst", "1.0"); from gi.repository import Gst' 2>/dev/null ||
  skip "Python does not find GStreamer (packages python3-gi and gir1.2-gstreamer-1.0)"

clip "$work/clip.mkv" 352 288 30 4 uniform:60,-30
# Presses, pulls to the right, holds, and lifts.
printf '%s\n' 0,0,0,0.3 0.5,0,0,-0.3 1,0.4,0,-0.3 1.8,0.4,0,-0.3 2,0.4,0,0.5 >"$work/hand"

pull() { # STORY OPTION...
  local story=$1
  shift
  "$root/pipelines/pull-character.sh" "$work/clip.mkv" --output "$work/film.mkv" --story "$story" -- "$@"
}
pull "$work/pulled.raw" device=sim "sim-hand=file:$work/hand" "log-location=$work/trace.csv" >"$work/places"
pull "$work/alone.raw" device=none >"$work/alone"

follows() { awk '$3 == "held" && $1 > 272 + 60 { n++ } END { exit !(n > 5) }' "$work/places"; }
is_pulled() { awk -F, 'NR > 1 && $8 < -0.15 { n++ } END { exit !(n > 200) }' "$work/trace.csv"; }
promise "the character follows the hand" follows
promise "and returns to its place" test "$(tail -n 1 "$work/places")" = "272 132 free"
promise "the leash pulls the hand back" is_pulled
promise "without a hand it stays" test "$(sort -u "$work/alone")" = "272 132 free"
promise "the story is the same, byte for byte" cmp "$work/pulled.raw" "$work/alone.raw"
promise "all of it" test "$(stat -c %s "$work/alone.raw")" = $((120 * 352 * 288 * 3 / 2))

# `refused WORDS ARGUMENT...`
refused() {
  ! "$root/pipelines/pull-character.sh" "$work/clip.mkv" "${@:2}" >"$work/said" 2>&1 &&
    grep "pull-character.sh: .*$1" "$work/said"
}
promise "the film itself is not overwritten" refused 'would overwrite the film' --output "$work/../${work##*/}/clip.mkv"
promise "what is no property of hapticsink is told" refused 'strength' --output "$work/no.mkv" -- strength=1
