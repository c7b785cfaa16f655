#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Damaged films, tracks and playlists, each given to a verb of haptic-track under strace. No run opens an address, or a
# file that the user did not name. Each run ends within 30 s without progress, and says in a sentence what is wrong, or
# succeeds.
#
# Usage: tests/referees/hostile-files.sh [RUNS [SEED]]
#   RUNS  how many (default: 300, about ten minutes)
#
# Takes the programs from build-tests/ or $FEELING_WIND_BUILD. Without ffmpeg or strace the exit status is 77.

export FEELING_WIND_BUILD=${FEELING_WIND_BUILD:-$(dirname "$0")/../../build-tests}
source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$(dirname "$0")/support.sh"

case ${1:-} in
--help | -h) show_help && exit ;;
esac
runs=${1:-300} seed=${2:-1}
for program in ffmpeg strace; do
  command -v $program >/dev/null || skip "$program is not installed"
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
strace -o "$work/trace" true 2>/dev/null || skip "no process may be traced here"
use_elements motionfield hapticconvert hapticmark
export FEELING_WIND_WEB=$root/pipelines/web
haptic_track=$build/gst-plugins/track/tools/haptic-track
damage=$build/tests/fuzz/open-fuzz
[ -x "$damage" ] || skip "there is no $damage"

# Whole ones: a film with sound, its copies with a track in each container, and the track in each form.
mkdir "$work/whole" "$work/in" "$work/out"
ffmpeg -v error -f lavfi -i testsrc2=size=96x64:rate=10:duration=3 -f lavfi -i sine=duration=3 -c:v libx264 -g 10 -bf 2 \
  -pix_fmt yuv420p -c:a aac "$work/whole/film.mp4" </dev/null
ffmpeg -v error -i "$work/whole/film.mp4" -an -c copy "$work/whole/film.mkv" </dev/null
"$haptic_track" author "$work/whole/film.mp4" "$work/whole/film.mkv" --output "$work/whole" >"$work/said" 2>&1 || true
"$haptic_track" author "$work/whole/film.mp4" >"$work/said" 2>&1 || fail "$(cat "$work/said")"
copy=$work/whole/film.haptic.ts
ffmpeg -v error -i "$copy" -map 0:v -c copy "$work/whole/bare.ts" </dev/null
for ending in klv txt mkv; do
  "$haptic_track" convert "$copy" "$work/whole/track.$ending"
done
cp "$root"/tests/data/golden*.{klv,hmpg,hjif} "$work/whole"
"$damage" --write "$work/in" "$runs" "$seed" "$work"/whole/* >/dev/null

# The user named these. Others are of the system: programs, libraries, plugins, devices, and what they keep for the user.
own="$work|$build|$root|/usr|/lib|/etc|/proc|/sys|/dev|/run|/tmp|/var/cache|/var/lib|${HOME:-/root}|${XDG_CACHE_HOME:-/root}"
slowest=0 longest_run='' failures=0
for number in $(seq 0 $((runs - 1))); do
  in=$work/in/$number out=$work/out/$number
  case $((number % 8)) in
  0) words=(info "$in") ;;
  1) words=(convert "$in" "$out.klv") ;;
  2) words=(convert "$in" "$out.wav") ;;
  3) words=(cut --with-video --from 1 --to 2 "$in" "$out.ts") ;;
  4) words=(plot "$in" "$out.png") ;;
  5) words=(author --output "$work/out" "$in") ;;
  6) words=(package --output "$out" "$in") ;;
  7) words=(compare "$in" "$copy") ;;
  esac
  status=0 begin=$EPOCHREALTIME
  timeout 90 strace -f -qq -e trace=openat,open,connect -o "$work/trace" "$haptic_track" "${words[@]}" \
    >"$work/said" 2>&1 </dev/null || status=$?
  ms=$((${EPOCHREALTIME/./} / 1000 - ${begin/./} / 1000))
  [ $ms -le $slowest ] || { slowest=$ms; longest_run="${words[0]} of input $number"; }
  wrong=''
  ! grep -qE 'sin6?_port=htons' "$work/trace" || wrong="it connects"
  ! grep -qE '/named[./"]' "$work/trace" || wrong="it opens what the content names" # as open-fuzz.cpp writes it
  other=$(sed -nE 's/.*open(at)?\(.*"(\/[^"]*)".*/\2/p' "$work/trace" | grep -vE "^($own)(/|\$)" | head -n 1) || true
  [ -z "$other" ] || wrong="it opens $other"
  [ $status -le 1 ] || [ $status = 3 ] || wrong="it ends with status $status"
  [ $status != 1 ] || grep -qE '^(haptic-track|"|0 written)|told apart' "$work/said" || wrong="it says nothing"
  [ $ms -le 45000 ] || wrong="it takes $ms ms"
  [ -z "$wrong" ] || { failures=$((failures + 1)); echo "input $number, ${words[0]}: $wrong"; tail -n 2 "$work/said"; }
done
echo "$runs runs, $failures wrong; the slowest one took $slowest ms ($longest_run)"
[ $failures = 0 ]
