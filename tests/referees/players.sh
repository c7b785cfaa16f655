#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Programs that we did not write read every container that haptic-track writes. A copy by ffmpeg or mkvmerge has its track
# at the right times, or the reader says that it is lost, as docs/formats/klv.md says. mpv and VLC play each file to its
# end and show no line of the track, though their users want English subtitles.
#
# Usage: tests/referees/players.sh
#
# Takes the programs from build-tests/ or $FEELING_WIND_BUILD. A program that is missing is named and left out. Without
# ffmpeg the exit status is 77.

export FEELING_WIND_BUILD=${FEELING_WIND_BUILD:-$(dirname "$0")/../../build-tests}
source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$(dirname "$0")/support.sh"

no_options "$@"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"
use_elements motionfield hapticconvert hapticmark
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export FEELING_WIND_WEB=$root/pipelines/web

# The program succeeds and has nothing to say.
silent() {
  local status=0
  "$@" >"$work/said" 2>&1 </dev/null || status=$?
  cat "$work/said"
  [ $status = 0 ] && [ ! -s "$work/said" ]
}
says_lost() {
  ! haptic_track info "$1" >"$work/said" 2>&1 && cat "$work/said" && grep -q 'there is no haptic track in this file' "$work/said"
}
same_track() {
  haptic_track compare --at-most 0 "$1" "$2" | tee "$work/said" && grep -q "^shift  *none" "$work/said"
}

ffmpeg -v error -f lavfi -i testsrc2=size=352x288:rate=30:duration=5 -f lavfi -i sine=duration=5 -c:v libx264 \
  -preset veryfast -g 30 -bf 2 -pix_fmt yuv420p -c:a aac "$work/film.mp4" </dev/null
ffmpeg -v error -i "$work/film.mp4" -an -c copy "$work/reel.mkv" </dev/null
for film in film.mp4 reel.mkv; do
  haptic_track author "$work/$film" >"$work/said" 2>&1 || fail "$(cat "$work/said")"
done
for carriage in mp4 ts; do
  haptic_track package --carriage $carriage --output "$work/$carriage" "$work/film.haptic.ts" >"$work/said" 2>&1 ||
    fail "$(cat "$work/said")"
done
cat "$work"/mp4/mp4-*/{head,0*}.mp4 >"$work/packaged.mp4"
cat "$work"/ts/ts-*/0*.ts >"$work/packaged.ts"
for ending in ts mkv; do
  haptic_track cut --with-video --from 1 --to 4 "$work/film.haptic.ts" "$work/cut.$ending" 2>/dev/null ||
    fail "no part is cut into .$ending"
done
files=(film.haptic.ts reel.haptic.mkv packaged.ts packaged.mp4 cut.ts cut.mkv)

for file in "${files[@]}"; do
  promise "ffmpeg decodes $file" silent ffmpeg -v error -i "$work/$file" -map 0:v -map '0:a?' -f null -
done
for file in film.haptic.ts packaged.ts cut.ts; do
  promise "ffmpeg copies $file" silent ffmpeg -y -v error -i "$work/$file" -map 0 -c copy "$work/copy.ts"
  promise "with its track at the right times" same_track "$work/$file" "$work/copy.ts"
done
for file in reel.haptic.mkv cut.mkv; do
  for ending in mkv mp4; do
    texts=()
    [ $ending = mkv ] || texts=(-c:s mov_text)
    promise "ffmpeg copies $file to .$ending" \
      silent ffmpeg -y -v error -i "$work/$file" -map 0 -c copy "${texts[@]}" "$work/copy.$ending"
    promise "with its track at the right times" same_track "$work/$file" "$work/copy.$ending"
  done
done
promise "ffmpeg copies packaged.mp4" silent ffmpeg -y -v error -i "$work/packaged.mp4" -map 0 -c copy "$work/copy.mp4"
promise "and that the track is lost is said" says_lost "$work/copy.mp4"

if command -v mkvmerge >/dev/null; then
  for file in "${files[@]}"; do
    promise "mkvmerge copies $file" silent mkvmerge -q -o "$work/copy.mkv" "$work/$file"
    case $file in
    *.mkv) promise "with its track at the right times" same_track "$work/$file" "$work/copy.mkv" ;;
    *) promise "and that the track is lost is said" says_lost "$work/copy.mkv" ;;
    esac
  done
else
  echo "   not run: mkvmerge is not installed (mkvtoolnix)"
fi

# `plays FILE COMMAND...`: the player ends by itself and $shown is not in what it says.
plays() {
  timeout 60 "$@" </dev/null >"$work/said" 2>&1 || { tail "$work/said" && return 1; }
  grep -q "$played" "$work/said" && ! grep "$shown" "$work/said"
}
if command -v mpv >/dev/null; then
  played='(End of file)' shown='(+) Subs'
  for file in "${files[@]}"; do
    promise "mpv plays $file" plays mpv --no-config --vo=null --ao=null --untimed --slang=en "$work/$file"
  done
else
  echo "   not run: mpv is not installed"
fi
if command -v cvlc >/dev/null; then
  played='codec (h264) started' shown='looking for spu decoder'
  # It does not run as root.
  as_user=()
  [ "$EUID" != 0 ] || as_user=(setpriv --reuid nobody --clear-groups env "HOME=$work")
  chmod -R a+rX "$work"
  for file in "${files[@]}"; do
    promise "VLC plays $file" plays "${as_user[@]}" cvlc --no-audio --vout=dummy --play-and-exit --rate 8 \
      --sub-language=eng -vv "$work/$file"
  done
else
  echo "   not run: VLC is not installed (vlc-bin)"
fi
