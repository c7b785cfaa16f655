#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Measures how much faster two processors author the chunks of a film than one. Nothing else should run meanwhile.
#
# Usage: tests/measure/benchmarks/author-cores.sh [--build BUILD] [VIDEO]
#   --build BUILD  the build folder (build)
#   VIDEO          without one, a minute of a test picture of 1920x1080, H.264

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

video=''
while [ $# -gt 0 ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --build)
    [ -d "${2:-}" ] || fail "--build needs a build folder; see --help"
    build=$(cd "$2" && pwd)
    export FEELING_WIND_BUILD=$build
    shift
    ;;
  -*) fail "unknown option '$1'; see --help" ;;
  *) video=$(realpath "$1") ;;
  esac
  shift
done
command -v parallel >/dev/null || fail "GNU parallel is not installed; as root run: apt-get install parallel"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
if [ -z "$video" ]; then
  video=$work/film.mp4
  ffmpeg -v error -f lavfi -i testsrc2=size=1920x1080:rate=30:duration=60 -c:v libx264 -preset veryfast -g 60 -pix_fmt yuv420p "$video"
fi

# `seconds PROCESSORS`: by parallel.sh, which runs a process for each.
seconds() {
  local TIMEFORMAT=%R
  mkdir "$work/$1"
  time (cd "$work/$1" && taskset -c "$1" "$root/pipelines/batch/parallel.sh" --chunks 6 --output "$work/$1" "$video" >"$work/$1.log" 2>&1) ||
    fail "$(tail -n 3 "$work/$1.log")"
}
one=$({ seconds 0; } 2>&1)
two=$({ seconds 0,1; } 2>&1)
cmp "$work/0/"*.haptic.* "$work/0,1/"*.haptic.* || fail "the copies differ"
awk -v one="$one" -v two="$two" 'BEGIN {
  printf "one processor %.1f s, two %.1f s: %.2f times as fast\n", one, two, one / two
}'
