#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# How well a thing is held: films whose points are known are followed from a press on, and judged by TAP-Vid's metric
# (docs/lab.md#held-things). The films are made once, which takes some minutes, and kept.
#
# Usage: tests/measure/felt/hold.sh [OPTION]...
#   --set SET           calm (default), gusts, or tuning, which thresholds were chosen with
#   --rate RATE         frames a second, 30 (default) or 60
#   --duration S        length of the films, 5 (default). 11 tells the error after 10 s too
#   --films FOLDER      where the films are kept (~/.cache/feeling-wind/hold)
#   --every N           takes every Nth point only (1; with --peers, 15)
#   --peers             one row for each of OpenCV's trackers. Takes ten minutes
#   --authored          holds tracks instead: of copies in which the points were followed, and in which author chose
#   --tap-vid FILE      judges by a file of TAP-Vid instead (tapvid_davis.pkl, tapvid_rgb_stacking.pkl)
#   --round-trip CLIP   holds moving places of any video for 60 frames, and back. May be repeated
#
# Takes the programs from build/.

source "$(dirname "$0")/../../../pipelines/shared/common.sh"
here=$root/tests/measure/felt

set=calm every='' rate=30 duration=5 films=${XDG_CACHE_HOME:-$HOME/.cache}/feeling-wind/hold peers='' authored=''
tap_vid=() clips=()
while [ $# -gt 0 ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --peers) peers=yes && shift && continue ;;
  --authored) authored=yes && shift && continue ;;
  --set | --rate | --duration | --films | --every | --tap-vid | --round-trip) [ $# -gt 1 ] || fail "$1 needs a value; see --help" ;;
  *) fail "unknown option '$1'; see --help" ;;
  esac
  case $1 in
  --set) set=$2 ;;
  --rate) rate=$2 ;;
  --duration) duration=$2 ;;
  --films) films=$2 ;;
  --every) every=$2 ;;
  --tap-vid) tap_vid+=("$2") ;;
  --round-trip) clips+=("$2") ;;
  esac
  shift 2
done

case $set in
tuning) wind=(11) cut_outs=(1) ;;
calm) wind=(14 15) cut_outs=(8 9) ;;
gusts) wind=(12 13) cut_outs=(2 3) ;;
*) fail "there is no set '$set'; see --help" ;;
esac
/usr/bin/python3 -c 'import numpy' 2>/dev/null || fail "Python has no numpy; install python3-numpy"
run=$build/tests/measure/felt/hold-run
[ -x "$run" ] || fail "'$run' is not built: meson configure $build -Dtests=enabled, then build again"
command -v ffmpeg >/dev/null || fail "ffmpeg is not installed; install the package ffmpeg"
find_plugins
judge=("$here/judge-hold.py" --run "$run")

if [ ${#tap_vid[@]} -gt 0 ]; then
  exec "${judge[@]}" --tap-vid "${tap_vid[@]}"
elif [ ${#clips[@]} -gt 0 ]; then
  exec "${judge[@]}" --round-trip "${clips[@]}"
fi

source "$here/film-and-places.sh"

# `film NAME COMMAND...` makes a film with its points, if it is not there. Without the photographs there are no cut-outs.
film() {
  local name status=0
  name=$films/$1-$rate-$duration-$(version_of "$program" "$here"/{cut-outs,films_with_points,photographs}.py)
  shift
  if [ ! -s "$name.csv" ]; then
    echo "Making $name.mkv ..." >&2
    "$@" --rate "$rate" --duration "$duration" --points "$name.csv.part" "$name.mkv" >&2 || status=$?
    [ "$status" != 77 ] || return 0
    [ "$status" = 0 ] || fail "the film could not be made; see above"
    mv "$name.csv.part" "$name.csv"
  fi
  judged+=("$name.mkv")
}

mkdir -p "$films"
judged=()
for seed in "${wind[@]}"; do
  film "wind-$seed" "$program" --width 1920 --height 1080 --seed "$seed"
done
for seed in "${cut_outs[@]}"; do
  for kind in leaf thing face; do
    film "$kind-$seed" "$here/cut-outs.py" --kind $kind --seed "$seed"
  done
done
[ -z "$peers" ] || every=${every:-15}
[ -z "$every" ] || judge+=(--every "$every")
if [ -n "$authored" ]; then
  judge=("$here/judge-hold.py" --run "$build/tests/measure/felt/hold-track" ${every:+--every "$every"})
  judge+=(--author "$build/gst-plugins/track/tools/haptic-track")
  "${judge[@]}" "${judged[@]}"
  "${judge[@]}" --choose "${judged[@]}"
  exit
fi
"${judge[@]}" "${judged[@]}"
[ -n "$peers" ] || exit 0
for tracker in lk csrt kcf medianflow mosse; do
  "${judge[@]}" --tracker $tracker --all-only "${judged[@]}"
done
