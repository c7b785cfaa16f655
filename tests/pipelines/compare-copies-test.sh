#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A hand cannot tell a film and its copies by other programs apart, wherever the times of the copies begin.

source "$(dirname "$0")/support.sh"

haptic_track=$build/gst-plugins/track/tools/haptic-track
use_elements motionfield hapticconvert
for program in ffmpeg mkvmerge; do
  command -v "$program" >/dev/null || skip "$program is not installed (packages ffmpeg and mkvtoolnix)"
done

clip "$work/clip.mkv" 160 120 30 4 leaf
quiet_ffmpeg() { ffmpeg -v error -nostdin -y "$@"; }
quiet_ffmpeg -i "$work/clip.mkv" -f lavfi -i sine=duration=4 -c:v libx264 -g 30 -bf 2 -pix_fmt yuv420p -c:a aac \
  "$work/film.mp4"
quiet_ffmpeg -i "$work/film.mp4" -c copy "$work/reel.mkv"
for film in film.mp4 reel.mkv; do
  promise "$film is authored" "$haptic_track" author "$work/$film"
done
ts=$work/film.haptic.ts mkv=$work/reel.haptic.mkv
cd "$work"
quiet_ffmpeg -i "$ts" -map 0 -c copy copy.ts
quiet_ffmpeg -i "$ts" -map 0 -c copy -output_ts_offset 3.575 moved.ts
quiet_ffmpeg -i "$mkv" -map 0 -c copy -output_ts_offset 0.575 moved.mkv
quiet_ffmpeg -i "$mkv" -map 0 -c copy -c:s mov_text copy.mp4
mkvmerge -q -o merged.mkv "$mkv"
"$haptic_track" convert "$ts" bare.klv
"$haptic_track" convert "$ts" alone.mkv

# `same A B START-KNOWN`
same() {
  local said
  said=$("$haptic_track" compare --json --at-most 0.1 "$1" "$2") || { echo "$said"; return 1; }
  head -n 1 <<<"$said"
  grep -qF "\"start_known\":$3," <<<"$said"
}
for copy in copy.ts moved.ts; do
  promise "$copy is as the original" same "$ts" "$copy" true
done
for copy in moved.mkv copy.mp4 merged.mkv; do
  promise "$copy is as the original" same "$mkv" "$copy" true
done
for track in bare.klv alone.mkv; do
  promise "$track has no video, and its start is fitted" same "$ts" "$track" false
done
promise "which is said" grep -q "^shift  *unknown, since nothing ties one of them to a video" \
  <("$haptic_track" compare "$ts" bare.klv)

# A track that is late beside its film is felt.
late() { ! "$haptic_track" compare --at-most 5 "$ts" late.ts; }
quiet_ffmpeg -i "$ts" -itsoffset 0.3 -i "$ts" -map 0:v -map 1:d -c copy late.ts
promise "a track 300 ms behind its film is not" late
"$haptic_track" convert late.ts late.klv
promise "and stays behind it without the film" grep -q '^  time       0\.300 to' <("$haptic_track" info late.klv)
