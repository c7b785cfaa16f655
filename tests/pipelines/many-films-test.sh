#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Films of every kind that people have: each plays, or one sentence says why it does not, in feeling-wind and in
# play-file.sh. None hangs: set TRIES to play each more than once, and PART=K/N for the K-th of N parts of the films.

source "$(dirname "$0")/support.sh"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"
program=$build/pipelines/feeling-wind/feeling-wind
tries=${TRIES:-1} part=${PART:-1/1}
export NO_AT_BRIDGE=1 GSETTINGS_BACKEND=memory XDG_CONFIG_HOME=$work/config XDG_CACHE_HOME=$work/cache

# `shows FILM PATTERN`: the program runs until it has written what matches the pattern, and ends.
shows() {
  local process status=0
  : >said # what the film before said would end this one before it begins
  "$program" --verbose "$1" >said 2>&1 &
  process=$!
  for _ in {1..1200}; do
    ! grep -qE -- "$2" said || break
    sleep 0.05
  done
  kill -INT "$process"
  for _ in {1..600}; do
    kill -0 "$process" 2>/dev/null || break
    sleep 0.05
  done
  ! kill -9 "$process" 2>/dev/null || echo "it did not end"
  wait "$process" || status=$?
  grep -qE -- "$2" said || status=1
  [ "$status" = 0 ] || { echo "status $status"; cat said; }
  return "$status"
}
# Inside the X server: `many-films-test.sh window FILM PATTERN FOLDER`.
if [ "${1:-}" = window ]; then
  cd "$4"
  for ((try = 1; try <= tries; try++)); do
    shows "$2" "$3" || exit
  done
  exit
fi

in_a_window() {
  in_window_system "$0" window "$work/$1" "$2" "$work"
}
without_a_window() {
  local try
  for ((try = 1; try <= tries; try++)); do
    ends "$@" || return
  done
  cat "$work/errors"
}
ends() {
  local status=0
  timeout -k 5 60 "$root/pipelines/play-file.sh" "$work/$1" -- device=sim >"$work/output" 2>"$work/errors" || status=$?
  # Ends by itself, with a sentence if it does not play.
  [ "$status" = 0 ] || { [ "$status" = 1 ] && [ "$(wc -l <"$work/errors")" = 1 ]; } || {
    cat "$work/output" "$work/errors"
    return 1
  }
  [ "$2" != 'first frame' ] || [ "$status" = 0 ]
}

# What each film is said to be; `first frame` if it plays.
declare -A expected=()
order=()
# `film NAME OPTION...` makes a film of half a second from a motion to the right.
clip "$work/right.mkv" 160 120 30 1 uniform:30,0
film() {
  local name=$1
  shift
  # An encoder that this Debian's ffmpeg does not have leaves the film out.
  ffmpeg -v error -y -i "$work/right.mkv" -t 0.5 "$@" "$work/$name" </dev/null 2>"$work/reason" || {
    echo "left out: $name: $(head -n 1 "$work/reason")"
    return 0
  }
  expect "$name" 'first frame'
}
expect() {
  expected[$1]=$2
  order+=("$1")
}
is_made() {
  [ -f "$work/$1" ]
}

h264=(-c:v libx264 -preset ultrafast -pix_fmt yuv420p)
# Codecs and containers.
film h264.mp4 "${h264[@]}"
film h264.mov "${h264[@]}"
film h264.flv "${h264[@]}"
film h264.ts "${h264[@]}"
film b-frames.mp4 -c:v libx264 -bf 3 -pix_fmt yuv420p
film fragmented.mp4 "${h264[@]}" -movflags frag_keyframe+empty_moov
film raw.h264 "${h264[@]}"
film hevc.mp4 -c:v libx265 -preset ultrafast -x265-params log-level=none -pix_fmt yuv420p -tag:v hvc1
film hevc-ten-bit.mkv -c:v libx265 -preset ultrafast -x265-params log-level=none -pix_fmt yuv420p10le
film av1.webm -c:v libaom-av1 -cpu-used 8 -usage realtime
film vp8.webm -c:v libvpx -deadline realtime
film vp9-ten-bit.webm -c:v libvpx-vp9 -deadline realtime -pix_fmt yuv420p10le
film theora.ogv -c:v libtheora
film mpeg1.mpg -c:v mpeg1video
film mpeg4.avi -c:v mpeg4
film mpeg4.3gp -c:v mpeg4
film wmv2.wmv -c:v wmv2
film mjpeg.avi -c:v mjpeg
film prores.mov -c:v prores_ks -pix_fmt yuv422p10le
film ffv1.mkv -c:v ffv1
film huffyuv.avi -c:v huffyuv
film rgb.mkv -c:v libx264rgb -preset ultrafast
film full-chroma.mkv -c:v libx264 -preset ultrafast -pix_fmt yuv444p
film uncompressed.y4m -pix_fmt yuv420p
# What a camera makes of it.
lay_on_its_side "$work/h264.mp4" "$work/rotated.mp4" && expect rotated.mp4 'first frame'
film ten-bit.mkv -c:v libx264 -preset ultrafast -pix_fmt yuv420p10le
film variable.mkv -vf 'select=mod(n\,5)-2' -fps_mode vfr "${h264[@]}"
film interlaced-50.mpg -vf scale=720:576,fps=50,tinterlace=interleave_top,fieldorder=tff -c:v mpeg2video -flags +ilme+ildct -r 25
film interlaced-h264.mkv -vf scale=160:128,tinterlace=interleave_top -c:v libx264 -flags +ilme+ildct -pix_fmt yuv420p
film odd-size.mkv -vf crop=159:119 -c:v mjpeg
film anamorphic.mp4 "${h264[@]}" -aspect 16:9
film frames-240.mp4 -vf fps=240 "${h264[@]}"
film slow.mkv -vf fps=4 "${h264[@]}"
film tiny.mkv -vf scale=16:16 -c:v ffv1
film wide.mkv -vf scale=1920:64 -c:v mjpeg
film dv.dv -vf scale=720:576 -r 25 -pix_fmt yuv420p -target pal-dv
film sound.mkv -f lavfi -i sine=duration=0.5 -map 0:v -map 1:a "${h264[@]}" -c:a libvorbis
film two-films.mkv -map 0:v -map 0:v "${h264[@]}"
film two-sounds.mkv -f lavfi -i sine=duration=0.5 -map 0:v -map 1:a -map 1:a "${h264[@]}" -c:a flac
film late.ts "${h264[@]}" -output_ts_offset 1000
printf '1\n00:00:00,000 --> 00:00:01,000\nwords\n' >"$work/words.srt"
film subtitles.mkv -i "$work/words.srt" -map 0:v -map 1:s "${h264[@]}"
film 'odd name %20 ü#?.mp4' "${h264[@]}"
# Two sizes of frames in one film.
if is_made h264.ts && ffmpeg -v error -i "$work/right.mkv" -t 0.5 -vf scale=320:240 "${h264[@]}" "$work/larger.ts" </dev/null; then
  cat "$work/h264.ts" "$work/larger.ts" >"$work/two-sizes.ts"
  expect two-sizes.ts 'first frame'
fi
head -c $(($(stat -c %s "$work/right.mkv") * 3 / 4)) "$work/right.mkv" >"$work/cut.mkv"
expect cut.mkv 'first frame'

# What is no film.
head -c $(($(stat -c %s "$work/h264.mp4") / 2)) "$work/h264.mp4" >"$work/cut.mp4" # its index is at the end
expect cut.mp4 'cannot be played|is not a film'
head -c 20000 /dev/zero >"$work/zero.mp4"
expect zero.mp4 'is not a film'
LC_ALL=C awk 'BEGIN { srand(1); for (i = 0; i < 20000; i++) printf "%c", 1 + int(255 * rand()) }' >"$work/noise.avi"
expect noise.avi 'is not a film'
: >"$work/empty.mp4"
expect empty.mp4 'is empty'
echo words >"$work/text.mp4"
expect text.mp4 'is not a film|cannot be played'
ffmpeg -v error -f lavfi -i sine=duration=0.5 "$work/sound.flac" </dev/null
expect sound.flac 'holds sound only'
ffmpeg -v error -i "$work/right.mkv" -frames:v 1 "$work/still.jpg" </dev/null
expect still.jpg 'still picture'
ffmpeg -v error -i "$work/right.mkv" -frames:v 1 "$work/still.png" </dev/null
expect still.png 'still picture'
ffmpeg -v error -i "$work/right.mkv" -t 0.3 "$work/animation.gif" </dev/null
expect animation.gif 'is an animation'
ffmpeg -v error -i "$work/sound.flac" -i "$work/still.jpg" -map 0 -map 1 -c:v copy -disposition:v attached_pic "$work/cover.mp3" </dev/null
expect cover.mp3 'holds sound only'
echo 'YUV4MPEG2 W64 H64 F30:1 Ip A1:1 C420jpeg' >"$work/none.y4m"
expect none.y4m 'holds no frames'
mkdir "$work/folder.mp4"
expect folder.mp4 'is a folder'

need_window_system
[ -x "$program" ] || skip "feeling-wind is not built (package libgtk-3-dev)"
gst-inspect-1.0 --exists gtksink || skip "gtksink is not installed (package gstreamer1.0-gtk3)"
promise "at least fifty films are made" test "${#order[@]}" -ge 50
for ((i = ${part%/*} - 1; i < ${#order[@]}; i += ${part#*/})); do
  name=${order[i]}
  promise "$name in a window (${expected[$name]})" in_a_window "$name" "${expected[$name]}"
  promise "$name without one" without_a_window "$name" "${expected[$name]}"
done
