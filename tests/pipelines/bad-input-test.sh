#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Bad input is answered by one sentence that says what is wrong, and a failure.

source "$(dirname "$0")/support.sh"

# `refuses PATTERN SCRIPT ARGUMENT...`: fails with one line on stderr that matches.
refuses() {
  local pattern=$1 script=$2
  shift 2
  if (cd "$work" && timeout 60 "$root/pipelines/$script" "$@") >"$work/stdout" 2>"$work/stderr"; then
    echo "NOT OK: $script $* succeeded"
    exit 1
  fi
  if [ "$(wc -l <"$work/stderr")" != 1 ] || ! grep -qE "^${script##*/}: .*$pattern" "$work/stderr"; then
    echo "NOT OK: $script $* said:"
    cat "$work/stderr"
    exit 1
  fi
  echo "ok: $script $*: $(cat "$work/stderr")"
}

LC_ALL=C awk 'BEGIN { srand(1); for (i = 0; i < 20000; i++) printf "%c", 1 + int(255 * rand()) }' >"$work/noise.avi"
: >"$work/empty.mp4"
gst-launch-1.0 -q audiotestsrc num-buffers=50 ! wavenc ! filesink "location=$work/sound.wav"
gst-launch-1.0 -q videotestsrc num-buffers=1 ! jpegenc ! filesink "location=$work/still.jpg"
clip "$work/clip.mkv" 352 288 30 1 uniform:10,0
mkdir "$work/folder"

refuses "no file" demo.sh --video "$work/missing.mp4"
refuses "folder" demo.sh --video "$work/folder"
refuses "not a video" demo.sh --video "$work/noise.avi"
refuses "is empty" demo.sh --video "$work/empty.mp4"
refuses "sound only" demo.sh --video "$work/sound.wav"
refuses "no camera '/dev/video99'" demo.sh --camera /dev/video99
refuses "not a camera" demo.sh --camera "$work/clip.mkv"
refuses "not a camera" demo.sh --camera /dev/null
refuses "still picture" demo.sh --video "$work/still.jpg"
refuses "cannot be written" demo.sh --video "$work/clip.mkv" --output /proc/demo-output
refuses "cannot be written" demo.sh --video "$work/clip.mkv" --output "$work/clip.mkv"
refuses "whole number" demo.sh --camera test --seconds soon
refuses "whole number" demo.sh --camera test --seconds 0
refuses "not both" demo.sh --camera test --video "$work/clip.mkv"
refuses "needs a value" demo.sh --video
refuses "sim, usb, usb:ID or auto" demo.sh --device joystick
refuses "SPIDAR" demo.sh --video "$work/clip.mkv" --device usb
refuses "unknown option '--speed'" demo.sh --speed 3

for script in play-file.sh play-file-with-display.sh; do
  refuses "there is no video; name a file" "$script"
  refuses "no file" "$script" "$work/missing.mp4"
  refuses "one input" "$script" "$work/clip.mkv" device=sim
done
ffmpeg -v error -i "$work/clip.mkv" -frames:v 5 "$work/animation.gif" </dev/null
refuses "make a video of it: ffmpeg" play-file.sh "$work/animation.gif"
for script in play-file.sh playback-speed.sh; do
  refuses "is empty" "$script" "$work/empty.mp4"
  refuses "not a video" "$script" "$work/noise.avi"
  refuses "sound only" "$script" "$work/sound.wav"
  refuses "still picture" "$script" "$work/still.jpg"
  refuses "not a video" "$script" "http://127.0.0.1:1/nothing.mp4"
done
cp "$work/clip.mkv" "$work/Interview: one.mkv"
plays_a_name_like_a_scheme() { cd "$work" && "$root/pipelines/play-file.sh" "Interview: one.mkv" -- device=sim; }
promise "a colon in a name is no scheme" plays_a_name_like_a_scheme
GST_PLUGIN_FEATURE_RANK=jpegdec:NONE,avdec_mjpeg:NONE refuses "is not installed .*JPEG" play-file.sh "$work/clip.mkv"
refuses "from 0.01 to 100" playback-speed.sh --speed 0 "$work/clip.mkv"
refuses "is empty" record.sh "$work/empty.mp4" "$work/never.ts"
refuses "still picture" record.sh "$work/still.jpg" "$work/never.ts"
promise "a recording that never began leaves no file" test ! -e "$work/never.ts"
refuses "is empty" paper/moving-picture.sh "$work/empty.mp4" "$work/never.webp"
refuses "not a video" paper/moving-picture.sh "$work/noise.avi" "$work/never.webp"
promise "nor does an animation" test ! -e "$work/never.webp"
refuses "unknown option '--bogus'" send.sh --bogus
refuses "no video to record" record.sh
refuses "no file to record into" record.sh "$work/clip.mkv"
refuses "end in .ts or .mkv" record.sh "$work/clip.mkv" "$work/out.mp4"
refuses "no file" record.sh "$work/missing.mp4" "$work/out.ts"
refuses "no file" play-track.sh "$work/missing.ts"
refuses "no video to send" send.sh
refuses "no file" send.sh "$work/missing.mp4"
refuses "more than one input" send.sh "$work/clip.mkv" "$work/clip.mkv"
cp "$work/clip.mkv" "$work/kept.mkv"
refuses "exists and is no description" send.sh --sdp "$work/kept.mkv" "$work/clip.mkv"
cmp "$work/kept.mkv" "$work/clip.mkv" || fail "send.sh wrote over a film"
refuses "exists and is no description" send.sh --sdp /dev/null "$work/clip.mkv"
refuses "needs --sdp" send.sh --srtp "$work/clip.mkv"
refuses "not a description" receive.sh --sdp "$work/clip.mkv"
refuses "--port needs an even number" receive.sh --port many
refuses "unknown option" receive.sh --fro
refuses "10 to 79 letters" send-ts.sh --passphrase short "$work/clip.mkv"
printf '\n' >"$work/no-words"
refuses "has no passphrase in its first line" send-ts.sh --passphrase-file "$work/no-words" "$work/clip.mkv"
refuses "RIST does not encrypt" send-ts.sh --rist --passphrase secret12345 "$work/clip.mkv"
refuses "needs --rist" send-ts.sh --to 10.0.0.1 "$work/clip.mkv"
refuses "not for --receive" send-ts.sh --receive "$work/clip.mkv"
refuses "no file" mouse.sh "$work/missing.mp4"
refuses "no file" hold.sh "$work/missing.mp4"
refuses "two numbers from 0 to 1" hold.sh --at 0.5 "$work/clip.mkv"
refuses "motion, carry or both" hold.sh --law pull "$work/clip.mkv"
refuses "not both" hold.sh --at 0.5,0.5 --grip "$work/clip.mkv"
refuses "no camera" camera.sh /dev/video99
refuses "not a camera" camera.sh /dev/null
refuses "no video to send" field-multicast.sh
refuses "no file" field-multicast.sh "$work/missing.mp4"
refuses "no camera" field-multicast.sh /dev/video99
refuses "239.0.0.0" field-multicast.sh --group 10.0.0.1 --test-source
refuses "no network interface 'wire'" field-multicast.sh --interface wire --receive
refuses "not for --receive" field-multicast.sh --receive "$work/clip.mkv"
for script in touch-depth.sh touch-colour.sh; do
  refuses "surface\+motion, surface or off, not 'hard'" "$script" --touch hard
  refuses "needs a value" "$script" --video
  refuses "unknown option '--bogus'" "$script" --bogus
  refuses "is not an option; give a video with --video" "$script" "$work/clip.mkv"
  refuses "no file" "$script" --video "$work/missing.mp4"
  refuses "still picture" "$script" --video "$work/still.jpg"
  refuses "cannot be written" "$script" --video "$work/clip.mkv" --output /proc/touch-output
done
refuses "leave log-location= out" touch-colour.sh --video "$work/clip.mkv" -- log-location="$work/mine.csv"
refuses "not both" touch-depth.sh --still --video "$work/clip.mkv"
refuses "unknown option '--table'" touch-depth.sh --table fabric
refuses "unknown option '--still'" touch-colour.sh --still
ffmpeg -v error -i "$work/clip.mkv" -vf crop=351:288:0:0 -c:v ffv1 -pix_fmt yuv444p "$work/odd.mkv" </dev/null
refuses "351 px wide and cannot be halved" touch-depth.sh --video "$work/odd.mkv"
refuses "silk" touch-colour.sh --table silk
refuses "noise.ini" touch-colour.sh --table "$work/noise.ini"
cp "$work/noise.avi" "$work/noise.ini"
refuses "noise.ini" touch-colour.sh --table "$work/noise.ini"
unset DISPLAY WAYLAND_DISPLAY
refuses "no display" play-file-with-display.sh "$work/clip.mkv"
refuses "no display" mouse.sh "$work/clip.mkv"
refuses "no display" hold.sh "$work/clip.mkv"
FEELING_WIND_BUILD=$work/nowhere GST_PLUGIN_PATH='' GST_PLUGIN_PATH_1_0='' \
  GST_REGISTRY=$work/registry.bin refuses "does not find the element" play-file.sh "$work/clip.mkv"

for script in demo play-file play-file-with-display camera mouse hold record play-track send receive send-ts field-multicast batch/parallel view paper/moving-picture paper/paper touch-depth touch-colour; do
  "$root/pipelines/$script.sh" --help >"$work/help"
  for line in "^Usage: pipelines/$script.sh" '^Examples?:$' "^  pipelines/$script.sh"; do
    grep -qE "$line" "$work/help" || { echo "NOT OK: $script.sh --help has no line $line"; exit 1; }
  done
  echo "ok: $script.sh --help"
done
