#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# How often a hand tells what a tracker gives it from the true motion of whole films (docs/lab.md#whole-films): the mean
# of 15 places of each film, for the trackers of this project and their peers. The films are drawn once and kept.
#
# Usage: tests/measure/felt/felt.sh [OPTION]...
#   --set SET          judge (default), or tuning, whose films may be looked at
#   --films FOLDER     where the films are kept (~/.cache/feeling-wind/felt)
#   --only GROUP       a group of films: wind, rest, sky, flat, light, grass, pan, shake, still. May be repeated
#   --method METHOD    fast, layers, opencv, each also with :mean or :pointed for average=; field, the coded fields of
#                      motionfield; author, those of haptic-track author; or a peer. May be repeated
#   --truth-of WHAT    square (default), or pointed: what moves with the pixel under the pointer
#   --output FILE      a line for each film and method: group,film,method,alpha,told (%),time (µs)
#   --picture FILE     a chart of the table (PNG), by gnuplot
#
# Takes the programs from build/. The peers need -Dbenchmarks=enabled.

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

felt=$root/tests/measure/felt
set=judge films=${XDG_CACHE_HOME:-$HOME/.cache}/feeling-wind/felt of=square output='' picture='' groups=() methods=()
while [ $# -gt 0 ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --set | --films | --only | --method | --truth-of | --output | --picture) [ $# -gt 1 ] || fail "$1 needs a value; see --help" ;;
  *) fail "unknown option '$1'; see --help" ;;
  esac
  case $1 in
  --set) set=$2 ;;
  --films) films=$2 ;;
  --only) groups+=("$2") ;;
  --method) methods+=("$2") ;;
  --truth-of) of=$2 ;;
  --output) output=$2 ;;
  --picture) picture=$2 ;;
  esac
  shift 2
done
case $set in
judge) seeds=(4711 90210) ;;
tuning) seeds=(1 2) ;;
*) fail "there is no set '$set'; see --help" ;;
esac
[[ $of =~ ^(square|pointed)$ ]] || fail "--truth-of is square or pointed, not '$of'"
[ ${#groups[@]} -gt 0 ] || groups=(wind rest sky flat light grass pan shake still)
run=$build/tests/measure/felt/felt-run
if [ ${#methods[@]} = 0 ]; then
  methods=(fast layers opencv)
  [ ! -x "$run" ] || methods+=(Farneback "DIS medium" "PyrLK crop")
fi
command -v ffmpeg >/dev/null || fail "ffmpeg is not installed; as root run: apt-get install ffmpeg"
source "$felt/film-and-places.sh"

# `draw NAME COMMAND...` draws a film with its truth, if it is not there.
draw() {
  local name=$1 status=0
  shift
  [ ! -d "$films/$name" ] || return 0
  echo "Drawing $name ..." >&2
  rm -rf "$films/.part"
  "$@" --truth "$films/.part" --places "$places" "$films/$name.mkv" >&2 2>"$work/errors" || status=$?
  [ "$status" != 77 ] || return 77
  [ "$status" = 0 ] || fail "$(tail -n 1 "$work/errors")"
  mv "$films/.part" "$films/$name"
}
# The films of a group: at 60 frames a second, and one at 30.
films_of() {
  local seed speed rate=60 name kind=$1 wind scenes
  wind=$(version_of "$program") scenes=$(version_of "$felt"/{scenes,photographs}.py)
  [ "$of" = square ] || kind=$1-$of
  for seed in "${seeds[@]}"; do
    case $1 in
    wind)
      name=wind-$of-$seed-$rate-$wind
      draw "$name" "$program" --seed "$seed" --rate $rate --duration 5 --truth-of "$of" && echo "$name"
      ;;
    still)
      for speed in 15 30 60 120 240 480; do
        name=$kind-$seed-$speed-$scenes
        draw "$name" "$felt/scenes.py" --scene still --seed "$seed" --speed $speed --duration 3 --truth-of "$of" && echo "$name"
      done
      ;;
    *)
      name=$kind-$seed-$rate-$scenes
      draw "$name" "$felt/scenes.py" --scene "$1" --seed "$seed" --rate $rate --truth-of "$of" && echo "$name"
      ;;
    esac
    rate=30
  done
}

# `ask METHOD FILM`: without the elements; prints the time of a frame.
ask() {
  ffmpeg -nostdin -v error -i "$2" -fps_mode passthrough -pix_fmt yuv420p -f yuv4mpegpipe - | "$run" "$1" "$work/said" "${places# }"
}
# The elements, as a hand gets it. The time is that of the tracker and the estimate alone.
track_live() {
  local method=${1%%:*} average=${1#*:} place branches=''
  [ "$average" != "$1" ] || average=model
  [ ! -x "$run" ] || ask "$method" "$2"
  rm -f "$work/said"/*
  for place in $places; do
    branches+=" t. ! roitracker method=$method pointer-source=property pointer-x=${place%,*} pointer-y=${place#*,}"
    branches+=" ! velocityavg average=$average ! hapticconvert ! meta/x-klv,parsed=true"
    branches+=" ! filesink async=false location=$work/said/${place/,/-}.klv"
  done
  # shellcheck disable=SC2086 # each word is one of gst-launch's
  gst-launch-1.0 -q filesrc location="$2" ! matroskademux name=demux demux.video_0 ! avdec_h264 ! tee name=t $branches >&2
}
track_field() {
  gst-launch-1.0 -q filesrc location="$1" ! matroskademux name=demux demux.video_0 ! avdec_h264 \
    ! motionfield ! hapticconvert ! meta/x-klv,parsed=true ! filesink location="$work/field.klv" >&2
}
# Without the track of the truth that a film may have.
track_authored() {
  rm -rf "$work/authored" "$work/field.klv"
  ffmpeg -nostdin -y -v error -i "$1" -map 0:v -c copy "$work/film.mkv"
  haptic_track author --output "$work/authored" "$work/film.mkv" >/dev/null
  haptic_track convert "$work/authored"/film.haptic.* "$work/field.klv" >/dev/null
}
# One track for all places.
for_all_places() {
  local place
  for place in $places; do ln -s "$work/field.klv" "$work/said/${place/,/-}.klv"; done
}
track() {
  rm -rf "$work/said" && mkdir "$work/said"
  case $1 in
  field) track_field "$2" && for_all_places ;;
  author) track_authored "$2" && for_all_places ;;
  fast* | opencv* | layers*) track_live "$1" "$2" ;;
  *)
    [ -x "$run" ] || fail "'$run' is not built: meson configure $build -Dtests=enabled -Dbenchmarks=enabled, then build again"
    ask "$1" "$2"
    ;;
  esac
}

if [ -n "$picture" ]; then
  command -v gnuplot >/dev/null || fail "gnuplot is not installed; as root run: apt-get install gnuplot-nox"
  [ -x "$run" ] || fail "'$run' is not built, which measures the times: meson configure $build -Dtests=enabled -Dbenchmarks=enabled, then build again"
fi
mkdir -p "$films"
[ -z "$picture" ] || output=${output:-$work/table.csv}
[ -z "$output" ] || echo "group,film,method,alpha,told,us" >"$output"
printf '| films |' && printf ' %s |' "${methods[@]}"
printf '\n|---|' && printf '%s' "${methods[@]/*/---|}" && echo
for group in "${groups[@]}"; do
  list=$(films_of "$group") || exit 1
  [ -n "$list" ] || continue # a package is missing
  mapfile -t names <<<"$list"
  printf '| %s (%d) |' "$group" ${#names[@]}
  for method in "${methods[@]}"; do
    for name in "${names[@]}"; do
      us=$(track "$method" "$films/$name.mkv")
      for alpha in 0.01 0.04; do
        for said in "$work/said"/*; do
          truth=$(basename "$said")
          haptic_track compare --json --shift 0 --alpha $alpha "$films/$name/${truth%.*}.txt" "$said"
        done | awk -F '[:,]' -v line="$group,$name,$method,$alpha" -v us="$us" '
          { sum += $2 }
          END { printf "%s,%.1f,%s\n", line, 100 * sum / NR, us }'
      done
    done >"$work/rows"
    [ -z "$output" ] || cat "$work/rows" >>"$output"
    awk -F , '{ sum[$4] += $5; us += $6; n[$4]++; rows++ }
      END {
        printf " %.1f / %.0f %%", sum["0.01"] / n["0.01"], sum["0.04"] / n["0.04"]
        if (us) printf ", %.0f µs", us / rows
        printf " |"
      }' "$work/rows"
  done
  echo
done
[ -z "$picture" ] || gnuplot -c "$felt/felt-chart.gp" "$output" "$picture"
