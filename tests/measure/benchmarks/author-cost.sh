#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Measures what authoring costs beside decoding: processor seconds of the decoder alone, of decoder and motionfield,
# and of haptic-track author, each the least of three. Nothing else should run meanwhile.
#
# Usage: tests/measure/benchmarks/author-cost.sh [--build BUILD] [--before BUILD] [VIDEO.mp4...]
#   --build BUILD   the build folder (build)
#   --before BUILD  an earlier build, whose motionfield is measured in the same run
#   VIDEO.mp4       H.264; without one, five seconds of a drawn film of 1920x1080

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

build=$root/build before='' videos=()
while [ $# -gt 0 ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --build) build=$(cd "$2" && pwd) && shift ;;
  --before) before=$(cd "$2" && pwd) && shift ;;
  -*) fail "unknown option '$1'; see --help" ;;
  *) videos+=("$1") ;;
  esac
  shift
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# `in_build BUILD COMMAND...` runs a command with the elements of a build.
in_build() {
  GST_PLUGIN_PATH_1_0=$1/gst-plugins GST_REGISTRY=$work/${1//\//-}.bin "${@:2}"
}

# `seconds BUILD COMMAND...` prints the least processor time of three runs.
seconds() {
  local least=1000000 hundredths TIMEFORMAT='%U %S'
  in_build "$@" >"$work/output" 2>&1 || fail "'${*:2}' failed: $(cat "$work/output")" # fills the registry, too
  for _ in 1 2 3; do
    hundredths=$({ time in_build "$@" >"$work/output" 2>&1; } 2>&1 | awk '{ print int(100 * ($1 + $2)) }')
    [ "$hundredths" -ge "$least" ] || least=$hundredths
  done
  awk -v n="$least" 'BEGIN { printf "%.2f", n / 100 }'
}

# `decode VIDEO [ELEMENT...]`: the words of a pipeline.
decode() {
  echo "-q filesrc location=$1 ! qtdemux ! h264parse ! avdec_h264 max-threads=1 ${2:-} ! fakesink"
}

authored() {
  rm -rf "$work/out" && mkdir "$work/out"
  "$build/gst-plugins/track/tools/haptic-track" author --output "$work/out" "$1"
}

if [ ${#videos[@]} = 0 ]; then
  in_build "$build" "$build/pipelines/films/wind-film" --width 1920 --height 1080 --duration 5 "$work/film.ts"
  ffmpeg -v error -i "$work/film.ts" -map 0:v -c copy "$work/film.mp4"
  videos=("$work/film.mp4")
fi
for video in "${videos[@]}"; do
  read -ra alone <<<"$(decode "$video")"
  read -ra field <<<"$(decode "$video" '! motionfield')"
  decoder=$(seconds "$build" gst-launch-1.0 "${alone[@]}")
  tracker=$(seconds "$build" gst-launch-1.0 "${field[@]}")
  author=$(seconds "$build" authored "$video")
  ratio() { awk -v a="$1" -v b="$2" 'BEGIN { printf "%.2f", a / b }'; }
  echo "$(basename "$video"): decoder $decoder s; with motionfield $tracker s, $(ratio "$tracker" "$decoder") times;" \
    "author $author s, $(ratio "$author" "$decoder") times"
  if [ -n "$before" ]; then
    earlier=$(seconds "$before" gst-launch-1.0 "${field[@]}")
    echo "  the earlier motionfield $earlier s, $(ratio "$earlier" "$tracker") times the present one"
  fi
done
