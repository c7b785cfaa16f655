#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# An MP4 that was trimmed without re-encoding hides frames by an edit list. Every frame that ffmpeg shows of it is in
# the copy and in the package, each with the field of its own time.

source "$(dirname "$0")/support.sh"

haptic_track=$build/gst-plugins/track/tools/haptic-track
use_elements motionfield hapticconvert
gst-inspect-1.0 --exists avdec_h264 || skip "there is no element avdec_h264"
for program in ffmpeg ffprobe python3; do
  command -v "$program" >/dev/null || skip "$program is not installed"
done
export FEELING_WIND_WEB=$root/pipelines/web

# `says STATUS TEXT COMMAND...`
says() {
  local status=0 wanted=$1 text=$2
  shift 2
  timeout 60 "$@" >"$work/output" 2>&1 || status=$?
  cat "$work/output"
  [ "$status" = "$wanted" ] && grep -qF -- "$text" "$work/output"
}

# The hashes of the frames that ffmpeg shows of the video.
shown() { ffmpeg -v error "${@:2}" -i "$1" -map 0:v:0 -fps_mode passthrough -f framemd5 - | sed '/^#/d; s/.*, *//'; }
# `ends_with COPY SOURCE [OPTION...]`: the copy ends with all frames of the source, in their order.
ends_with() {
  local wanted
  shown "$2" >"$work/wanted"
  shown "$1" "${@:3}" >"$work/copied"
  wanted=$(wc -l <"$work/wanted")
  echo "$wanted frames of the source, $(wc -l <"$work/copied") in the copy"
  [ "$wanted" -gt 0 ] && tail -n "$wanted" "$work/copied" | cmp - "$work/wanted"
}
# `in_step COPY SOURCE`: the first field has the time of the first frame that the source shows.
in_step() {
  local shown_frames
  shown_frames=$(shown "$2" | wc -l)
  ffprobe -v error -show_entries packet=codec_type,pts_time -of csv=p=0 "$1" | tr -d ' ' |
    awk -F, -v "shown=$shown_frames" '
    $1 == "video" { times[++frames] = $2 }
    ($1 == "data" || $1 == "subtitle") && (!fields++ || $2 < field) { field = $2 }
    END {
      for (i = 2; i <= frames; i++) # a few steps: frames are reordered within a few places
        for (j = i; j > 1 && times[j] < times[j - 1]; j--) { t = times[j]; times[j] = times[j - 1]; times[j - 1] = t }
      first = times[frames - shown + 1]
      print fields " fields from " field " s on, the first shown frame at " first " s"
      exit !(field - first < 0.001001 && first - field < 0.001001) # 1 ms, of numbers with six digits
    }'
}

ffmpeg -v error -f lavfi -i testsrc2=size=352x288:rate=30:duration=5 -f lavfi -i sine=duration=5 \
  -c:v libx264 -preset veryfast -g 60 -bf 2 -pix_fmt yuv420p -c:a aac "$work/whole.mp4"
mkdir "$work/in" "$work/out"
cut_to() { ffmpeg -v error "${@:2}" -c copy "$work/in/$1"; }
cut_to inside.mp4 -ss 0.5 -i "$work/whole.mp4"
cut_to between-frames.mp4 -ss 0.517 -i "$work/whole.mp4"
cut_to both-ends.mp4 -ss 0.5 -i "$work/whole.mp4" -t 3
cut_to silent.mp4 -ss 0.9 -i "$work/whole.mp4" -an
cut_to late-sound.mp4 -ss 0.5 -i "$work/whole.mp4" -itsoffset 0.7 -i "$work/whole.mp4" -map 0:v -map 1:a
cut_to empty-edit.mp4 -itsoffset 0.4 -ss 0.5 -i "$work/whole.mp4"
cut_to late.mkv -itsoffset 3 -i "$work/whole.mp4"
cut_to plain.avi -i "$work/whole.mp4" -an
# Time stamps of MPEG-TS have 33 bits: they begin again after 95 443.7 s.
cut_to wraps.ts -i "$work/whole.mp4" -output_ts_offset 95441

for film in "$work"/in/*; do
  name=$(basename "$film")
  promise "$name is authored" says 0 "1 written" "$haptic_track" author --output "$work/out" "$film"
  copy=$(echo "$work/out/${name%.*}".haptic.*)
  promise "every frame of $name is in the copy" ends_with "$copy" "$film"
  promise "and the fields begin with the first of them" in_step "$copy" "$film"
  promise "with a field for each" says 0 "fields     $(wc -l <"$work/wanted")" "$haptic_track" info "$copy"
done
promise "that hidden frames are seen is said" says 0 "15 frames before the cut" \
  "$haptic_track" author --output "$work" "$work/in/inside.mp4"

# `edit ENTRY...`: a copy whose video has these entries in its edit list, each "duration media-time rate".
edit() {
  python3 - "$work/in/silent.mp4" "$work/edited.mp4" "$@" <<'END'
import struct, sys

film = open(sys.argv[1], "rb").read()
entries = [tuple(int(word) for word in entry.split()) for entry in sys.argv[3:]]
new = struct.pack(">II", 0, len(entries)) + b"".join(struct.pack(">IiHH", *entry, 0) for entry in entries)


def edited(boxes):
    out = b""
    while boxes:
        size, kind = struct.unpack(">I4s", boxes[:8])
        body, boxes = boxes[8:size], boxes[size:]
        if kind in (b"moov", b"trak", b"edts"):
            body = edited(body)
        elif kind == b"elst":
            body = new
        out += struct.pack(">I4s", len(body) + 8, kind) + body
    return out


at = film.index(b"moov") - 4  # behind the frames, whose places stay
open(sys.argv[2], "wb").write(film[:at] + edited(film[at:]))
END
}
edit "1000 30720 1" "1000 0 1"
promise "a video of two parts in another order is refused" says 1 "joins several parts" \
  "$haptic_track" author "$work/edited.mp4"
edit "1000 0 1" "1000 30720 1"
promise "and one with a gap" says 1 "joins several parts" "$haptic_track" author "$work/edited.mp4"
promise "nothing is left" test "$(cd "$work" && echo edited*)" = edited.mp4

# Beside a track such a file is cut, too. The first field of the track is a key field at 1 s.
"$haptic_track" author --output "$work" "$work/whole.mp4" >/dev/null
"$haptic_track" convert "$work/whole.haptic.ts" "$work/track.mkv"
ffmpeg -v error -i "$work/whole.mp4" -i "$work/track.mkv" -map 0 -map 1 -c copy -c:s mov_text "$work/tracked.mp4"
ffmpeg -v error -ss 0.99 -i "$work/tracked.mp4" -map 0 -c copy "$work/trimmed.mp4"
for part in part.ts part.mkv; do
  promise "$part of a trimmed video is cut" "$haptic_track" cut --with-video --from 0 --to 9 "$work/trimmed.mp4" "$work/$part"
  promise "every frame is in $part" ends_with "$work/$part" "$work/trimmed.mp4"
  promise "and the fields begin with the first of them" in_step "$work/$part" "$work/trimmed.mp4"
done
promise "a part that begins behind a shown key frame hides nothing" "$haptic_track" cut --with-video --from 1.5 --to 9 \
  "$work/trimmed.mp4" "$work/late.ts"
promise "and begins with that frame" ends_with "$work/whole.mp4" "$work/late.ts"

# A package begins where the video does.
promise "a trimmed video is packaged" says 0 "written: " \
  "$haptic_track" package --output "$work/web" "$work/in/inside.mp4"
list=$(echo "$work"/web/*/film.m3u8)
promise "with all its frames" ends_with "$list" "$work/in/inside.mp4" -allowed_extensions ALL
promise "and begins at the cut" grep -qx '#EXT-X-START:TIME-OFFSET=0.500000,PRECISE=YES' "$list"
