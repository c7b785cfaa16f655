#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# haptic-track author: what the copies hold, that they can be trusted, and what happens when something goes wrong.

source "$(dirname "$0")/support.sh"

haptic_track=$build/gst-plugins/track/tools/haptic-track
use_elements motionfield hapticconvert
for element in x264enc avdec_h264; do
  gst-inspect-1.0 --exists "$element" || skip "there is no element $element"
done

# `video FILE WIDTH SECONDS [MUXER]`: H.264 whose left half moves up and the right one down, with sound.
video() {
  "$MAKE_CLIP" "$2" 288 30 "$3" halves:0,-100,0,100 |
    gst-launch-1.0 -q fdsrc ! rawvideoparse format=gray8 "width=$2" height=288 framerate=30/1 ! videoconvert \
      ! x264enc tune=zerolatency ! h264parse ! queue ! mux. \
      audiotestsrc "num-buffers=$((43 * $3))" ! audioconvert ! avenc_aac ! aacparse ! queue ! mux. \
      "${4:-mp4mux}" name=mux ! filesink "location=$1"
}
author() { "$haptic_track" author "$@"; }
# `says STATUS TEXT COMMAND...`
says() {
  local status=0 wanted=$1 text=$2
  shift 2
  "$@" >"$work/output" 2>&1 || status=$?
  cat "$work/output"
  [ "$status" = "$wanted" ] && grep -qF -- "$text" "$work/output"
}
# The coded pictures, whatever stands around them: `essence FILE`.
essence() {
  ffmpeg -v error -i "$1" -map 0:v:0 -c copy -bsf:v h264_mp4toannexb,filter_units=remove_types=6-9 -f h264 - | md5sum
}
same_essence() { [ "$(essence "$1")" = "$(essence "$2")" ]; }

mkdir "$work/in" "$work/out"
video "$work/in/wind.mp4" 352 4
video "$work/in/sea.mkv" 352 2 matroskamux

promise "two videos get their copies" says 0 "2 written, 0 there already, 0 failed" \
  author --jobs 2 --output "$work/out" "$work/in/wind.mp4" "$work/in/sea.mkv"
small() { local mb; mb=$(sed -n 's/.* at most \([0-9]*\) MB a process/\1/p' "$work/output") && [ "$mb" -gt 0 ] && [ "$mb" -le 200 ]; }
promise "in no more than 200 MB each" small
promise "the picture of an MP4 is untouched" same_essence "$work/in/wind.mp4" "$work/out/wind.haptic.ts"
promise "and that of Matroska" same_essence "$work/in/sea.mkv" "$work/out/sea.haptic.mkv"
promise "the sound is there" says 0 "audio/mpeg" "$haptic_track" info "$work/out/wind.haptic.ts"
promise "there is a field for each picture" says 0 "fields     120" "$haptic_track" info "$work/out/wind.haptic.ts"
promise "they are not done again" says 0 "0 written, 2 there already, 0 failed" \
  author --output "$work/out" "$work/in/wind.mp4" "$work/in/sea.mkv"

# `felt FILE DEMUXER CAPS X SIGN`: a hand there feels its half of the picture.
felt() {
  gst-launch-1.0 -q filesrc "location=$1" ! "$2" ! "$3" ! hapticconvert ! hapticsink device=sim "sim-hand=hold:$4,0,0" \
    "log-location=$work/felt.csv" || return 1
  awk -F, -v "sign=$5" 'NR > 1 && $9 * sign > 0.4 { right++ } NR > 1 && $9 * sign < -0.1 { wrong++ }
    END { print right + 0 " ms in the right direction, " wrong + 0 " in the other"
          exit !(right > 500 && wrong == 0) }' "$work/felt.csv"
}
promise "on the left one feels the motion up" felt "$work/out/wind.haptic.ts" tsdemux meta/x-klv -0.5 1
promise "on the right the motion down" felt "$work/out/sea.haptic.mkv" matroskademux text/x-raw 0.5 -1

# Killed at any moment, and run again: the same bytes.
killed_and_again() {
  local delay
  for delay in 0.15 0.3 0.45 0.6; do
    rm -rf "$work/again"
    mkdir "$work/again"
    author --jobs 2 --output "$work/again" "$work"/in/* >/dev/null 2>&1 &
    sleep "$delay"
    kill -KILL $!
    wait $! 2>/dev/null || true
    while pgrep -f "author --jobs 2 --output $work/again" >/dev/null; do sleep 0.02; done
    author --output "$work/again" "$work"/in/* >/dev/null 2>&1 || return 1
    diff -r "$work/out" "$work/again" || return 1
  done
}
promise "killed and run again it makes the same bytes" killed_and_again

# What cannot be done is said, and the rest goes on.
head -c $(($(stat -c %s "$work/in/sea.mkv") / 2)) "$work/in/sea.mkv" >"$work/half.mkv"
head -c 3000 "$work/in/wind.mp4" >"$work/short.mp4"
gst-launch-1.0 -q audiotestsrc num-buffers=20 ! wavenc ! filesink "location=$work/sound.wav"
echo 'no video' >"$work/text.mp4"
video "$work/narrow.ts" 320 1 mpegtsmux
video "$work/wide.ts" 352 1 mpegtsmux
cat "$work/narrow.ts" "$work/wide.ts" >"$work/turns.ts"
mkdir "$work/foreign"
echo 'my notes' >"$work/foreign/wind.haptic.ts"

promise "a file that ends in the middle" says 1 "it was not copied or recorded to its end" author "$work/half.mkv"
promise "a file that ends before its first picture" says 1 "1 failed" author "$work/short.mp4"
promise "a file without a video" says 1 "there is no video in this file" author "$work/sound.wav"
promise "a file that is none" says 1 '1 failed' author "$work/text.mp4"
promise "a missing file" says 1 'there is no such file' author "$work/missing.mp4"
promise "a picture that changes its size" says 1 'size changes from 320 x 288 to 352 x 288' author "$work/turns.ts"
promise "an output that is not ours stays" says 1 'holds no motion fields' \
  author --output "$work/foreign" "$work/in/wind.mp4"
promise "as it was" grep -q 'my notes' "$work/foreign/wind.haptic.ts"
promise "a full disk" says 1 '1 failed' \
  bash -c "ulimit -f 100; mkdir '$work/full'; '$haptic_track' author --output '$work/full' '$work/in/wind.mp4'"
promise "the other files go on" says 1 "1 written, 0 there already, 1 failed" \
  author --output "$work/foreign" "$work/missing.mp4" "$work/in/sea.mkv"
nothing_half_written() {
  ! find "$work" -name '*.part' | grep . && ! find "$work" -path "$work/full/*" | grep . &&
    ! find "$work" -name 'half.haptic*' -o -name 'short.haptic*' -o -name 'turns.haptic*' -o -name 'sound.haptic*' | grep .
}
promise "nothing half-written is left" nothing_half_written

# Pictures of it.
promise "a picture of the field" "$haptic_track" plot "$work/out/wind.haptic.ts" "$work/field.png"
promise "and one that moves" "$haptic_track" plot "$work/out/sea.haptic.mkv" "$work/field.gif"
# `has_arrows FILE COUNT`: so many pixels of its last picture have their color.
has_arrows() {
  ffmpeg -v error -i "$1" -update 1 -f image2 -c:v ppm "$work/last.ppm" -y
  ffmpeg -v error -i "$work/last.ppm" -f rawvideo -pix_fmt rgb24 - | od -An -v -tu1 -w3 |
    awk -v "least=$2" '$1 > 200 && $2 > 160 && $3 < 80 { n++ } END { print n + 0 " yellow pixels"; exit n < least }'
}
promise "it has arrows" has_arrows "$work/field.png" 1000
promise "so has the other" has_arrows "$work/field.gif" 1000

# Many at once.
cluster=$root/pipelines/author-cluster.sh
promise "without videos it asks for them" says 1 'which videos' "$cluster"
promise "a list is for an array of jobs" says 1 'SLURM_ARRAY_TASK_ID' "$cluster" --list "$0"
printf '%s\n' "$work/in/sea.mkv" "$work/in/wind.mp4" >"$work/list"
mkdir "$work/slurm" "$work/parallel"
promise "a job of an array does its line" env SLURM_ARRAY_TASK_ID=2 "$cluster" --output "$work/slurm" --list "$work/list"
promise "and no other" cmp "$work/out/wind.haptic.ts" "$work"/slurm/*
command -v parallel >/dev/null || skip "parallel is not installed"
promise "parallel does all" "$cluster" --output "$work/parallel" "$work/in/wind.mp4" "$work/in/sea.mkv"
promise "to the same bytes" diff -r "$work/out" "$work/parallel"
