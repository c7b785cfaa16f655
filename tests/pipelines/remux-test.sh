#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The table of docs/formats/klv.md: a copy of an authored film by another program has its track in step with the
# picture within 1 ms, or a sentence says that it is lost.

source "$(dirname "$0")/support.sh"

/usr/bin/python3 -c 'import gi; gi.require_version("GstApp", "1.0"); from gi.repository import GstApp' 2>/dev/null ||
  skip "Python does not find GStreamer (packages python3-gi and gir1.2-gst-plugins-base-1.0)"
for program in ffmpeg mkvmerge; do
  command -v $program >/dev/null || skip "$program is not installed (packages ffmpeg and mkvtoolnix)"
done

quiet_ffmpeg() {
  ffmpeg -v error -nostdin -y "$@" 2>"$work/ffmpeg" || { cat "$work/ffmpeg"; return 1; }
}

# `demuxer_of FILE`, `stream_of FILE`: how play-track.sh reads it.
demuxer_of() {
  case $1 in
  *.ts) echo tsdemux ;;
  *.mkv) echo matroskademux ;;
  *) echo qtdemux ;;
  esac
}
stream_of() {
  haptic_track info "$1" | sed -n 's/^  stream  *//p'
}

fields_of() {
  haptic_track info "$1" | sed -n 's/^  fields  *//p'
}

shift_in() {
  /usr/bin/python3 "$root/tests/pipelines/track-shift.py" "$original" "$(demuxer_of "$original")" \
    "$(stream_of "$original")" "$1" "$(demuxer_of "$1")" "$(stream_of "$1")"
}

# `in_step COPY SAMPLES`: so many samples at least have their frame beside them, within 1 ms.
in_step() {
  shift_in "$1" >"$work/shift" || return 1
  cat "$work/shift"
  awk -v "samples=$2" 'NR == 1 { exit !($1 >= samples && $3 <= 1) }' "$work/shift"
}

# The reader says that there is no track.
no_track() {
  ! haptic_track info "$1" >"$work/said" 2>&1 && cat "$work/said" && grep -q 'there is no haptic track in this file, only' "$work/said"
}

# The track is there, not felt, and the reader says why.
untied() {
  shift_in "$1" >"$work/shift" || return 1
  cat "$work/shift"
  grep -q '^0 samples' "$work/shift" && grep -q 'has lost its time stamps, so nothing ties it' "$work/shift"
}
start_unknown() {
  haptic_track compare --json "$original" "$1" | tee "$work/said" && grep -q '"start_known":false' "$work/said"
}

clip "$work/clip.mkv" 160 120 30 8 uniform:37,11
for film in film.mp4 reel.mkv; do
  quiet_ffmpeg -i "$work/clip.mkv" -f lavfi -i sine=duration=8 -c:v libx264 -g 30 -bf 2 -pix_fmt yuv420p \
    -c:a aac "$work/$film"
  haptic_track author --output "$work" "$work/$film" >"$work/author" || fail "$(cat "$work/author")"
done

original=$work/film.haptic.ts
promise "ffmpeg, TS to TS" quiet_ffmpeg -i "$original" -map 0 -c copy "$work/copy.ts"
promise "is in step" in_step "$work/copy.ts" 240
promise "ffmpeg, cut at 5.3 s" quiet_ffmpeg -ss 5.3 -i "$original" -map 0 -c copy "$work/cut.ts"
promise "is in step" in_step "$work/cut.ts" 45
promise "ffmpeg, the copy copied" quiet_ffmpeg -i "$work/copy.ts" -map 0 -c copy "$work/again.ts"
promise "is in step" in_step "$work/again.ts" 240
promise "ffmpeg, HLS" quiet_ffmpeg -i "$original" -map 0 -c copy -f hls -hls_time 2 -hls_list_size 0 \
  -hls_segment_filename "$work/segment%d.ts" "$work/list.m3u8"
for segment in 0 1 2 3; do
  promise "segment $segment is in step" in_step "$work/segment$segment.ts" 55
done
promise "haptic-track, a part" haptic_track cut --with-video --from 2 --to 5 "$original" "$work/part.ts"
# From the key frame before to the one behind. Each frame is after the tables of the transport stream.
frames_in() {
  gst-launch-1.0 -v filesrc "location=$1" ! tsdemux ! h264parse ! avdec_h264 ! identity silent=false ! fakesink |
    grep -c 'last-message = chain'
}
promise "has all its frames" test "$(frames_in "$work/part.ts")" = 120
promise "GStreamer, TS to TS" gst-launch-1.0 -q mpegtsmux name=m ! filesink "location=$work/gst.ts" \
  filesrc "location=$original" ! tsdemux name=d d. ! meta/x-klv ! queue ! m. d. ! h264parse ! queue ! m. \
  d. ! aacparse ! queue ! m.
promise "is in step" in_step "$work/gst.ts" 240
promise "GStreamer, TS to Matroska" gst-launch-1.0 -q matroskamux name=m ! hapticmark ! filesink "location=$work/gst.mkv" \
  filesrc "location=$original" ! tsdemux name=d d. ! meta/x-klv ! hapticconvert ! text/x-raw ! queue ! m. \
  d. ! h264parse ! queue ! m. d. ! aacparse ! queue ! m.
promise "is in step" in_step "$work/gst.mkv" 240
for ending in mkv mp4; do
  promise "ffmpeg, TS to $ending" quiet_ffmpeg -i "$original" -c copy "$work/lost.$ending"
  promise "says that the track is lost" no_track "$work/lost.$ending"
  promise "ffmpeg, and back to TS" quiet_ffmpeg -i "$work/lost.$ending" -map 0 -c copy "$work/lost.ts"
  promise "says so too" no_track "$work/lost.ts"
done
promise "mkvmerge, TS to Matroska" mkvmerge -q -o "$work/merged.mkv" "$original"
promise "says that the track is lost" no_track "$work/merged.mkv"

# mpegtsmux without hapticmark, as in gst.ts.
for cut in 0 5.3; do
  promise "ffmpeg, from $cut s of a TS without mark" quiet_ffmpeg -ss $cut -i "$work/gst.ts" -map 0 -c copy "$work/untied.ts"
  promise "says that nothing ties it" untied "$work/untied.ts"
  promise "and compare says that its start is unknown" start_unknown "$work/untied.ts"
done

original=$work/reel.haptic.mkv
promise "ffmpeg, Matroska to Matroska" quiet_ffmpeg -i "$original" -map 0 -c copy "$work/copy.mkv"
promise "is in step" in_step "$work/copy.mkv" 238
promise "ffmpeg, cut at 5.3 s" quiet_ffmpeg -ss 5.3 -i "$original" -map 0 -c copy "$work/cut.mkv"
promise "is in step" in_step "$work/cut.mkv" 45
for ending in mp4 mov; do
  promise "ffmpeg, Matroska to $ending" quiet_ffmpeg -i "$original" -map 0 -c copy -c:s mov_text "$work/copy.$ending"
  promise "is in step" in_step "$work/copy.$ending" 238
  promise "and has every field" test "$(fields_of "$work/copy.$ending")" = "$(fields_of "$original")"
done
promise "ffmpeg, Matroska to TS" quiet_ffmpeg -i "$original" -map 0 -c copy "$work/lost.ts"
promise "says that the track is lost" no_track "$work/lost.ts"
promise "mkvmerge, Matroska to Matroska" mkvmerge -q -o "$work/merged.mkv" "$original"
promise "is in step" in_step "$work/merged.mkv" 238
# default and forced
no_player_shows_it() {
  ffprobe -v error -select_streams s -show_entries stream_disposition=default,forced -of csv=p=0 "$1" | grep -x 0,0
}
for copy in copy merged; do
  promise "no player shows the track of this $copy as subtitles" no_player_shows_it "$work/$copy.mkv"
done
promise "mkvmerge, a part" mkvmerge -q --split parts:3s-6s -o "$work/part.mkv" "$original"
promise "is in step" in_step "$work/part.mkv" 85
promise "GStreamer, Matroska to TS" gst-launch-1.0 -q mpegtsmux name=m ! hapticmark ! filesink "location=$work/gst2.ts" \
  filesrc "location=$original" ! matroskademux name=d d.subtitle_0 ! hapticconvert ! meta/x-klv ! queue ! m. \
  d. ! h264parse ! queue ! m. d. ! aacparse ! queue ! m.
promise "is in step" in_step "$work/gst2.ts" 238
