#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# What haptic-track writes has an end that is known before it begins, and what is not whole does not stay.

source "$(dirname "$0")/support.sh"

haptic_track=$build/gst-plugins/track/tools/haptic-track
use_elements hapticconvert hapticarray
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"

# `says STATUS TEXT COMMAND...`
says() {
  local status=0 wanted=$1 text=$2
  shift 2
  timeout 100 "$@" >"$work/output" 2>&1 || status=$?
  cat "$work/output"
  [ "$status" = "$wanted" ] && grep -qF -- "$text" "$work/output"
}
leaves_nothing() { [ -z "$(find "$work" -name '*.part*')" ]; }

# `track FILE SECONDS...`: a sample at each time, as text.
track() {
  local file=$1 seconds
  shift
  for seconds; do
    echo "hv1 point t=$seconds d=0.033333 i=0.033333 vx=100 vy=0 spin=0 div=0 x=0.5 y=0.5 w=0.1 h=0.1 conf=1" \
      "pic=352x288 par=1:1 n=17 model=translation"
  done >"$file"
}

# A few words make no file of days.
track "$work/days.txt" 0 0.033333 100000 100000.033333
for ending in wav ahap; do
  promise "a track of days makes no .$ending" says 1 "at most 27 h are written" \
    "$haptic_track" convert "$work/days.txt" "$work/days.$ending"
  promise "and nothing is left" test ! -e "$work/days.$ending"
done
# The sizes in a .wav have 32 bits.
track "$work/hour.txt" 0 0.033333 3600
promise "a .wav that would be too large is refused" says 1 "12 channels of sound have room for" \
  "$haptic_track" convert "$work/hour.txt" "$work/hour.wav"
promise "before it is begun" test ! -e "$work/hour.wav"
promise "times that go back make no file of centuries" track "$work/back.txt" 5 5.033333 4.9
promise "but one of their length" timeout 60 "$haptic_track" convert "$work/back.txt" "$work/back.wav"
promise "which is short" test "$(stat -c %s "$work/back.wav")" -lt 4000000

# A pattern for telephones needs no room for its sound.
in_little_memory() { (ulimit -v 1500000 && "$haptic_track" convert "$@"); } # KiB
promise "an hour as a pattern" in_little_memory "$work/hour.txt" "$work/hour.ahap"

# Sound that ends early beside a video of many bits.
ffmpeg -v error -f lavfi -i testsrc2=size=640x480:rate=30:duration=20 -f lavfi -i sine=duration=1 -map 0 -map 1 \
  -vf noise=alls=60:allf=t -c:v libx264 -preset ultrafast -qp 10 -g 30 -pix_fmt yuv420p -c:a aac "$work/film.ts"
track "$work/track.txt" $(seq 0 0.5 19)
promise "a track is put beside the video" "$haptic_track" convert "$work/track.txt" "$work/track.ts"
ffmpeg -v error -i "$work/film.ts" -i "$work/track.ts" -map 0 -map 1 -c copy "$work/recording.ts"
promise "a cut that stands still ends with a sentence" says 1 "the film stood still for 30 s" \
  "$haptic_track" cut --with-video --from 1 "$work/recording.ts" "$work/cut.mkv"
promise "and leaves nothing" leaves_nothing

# `interrupted SIGNAL COMMAND...`: the signal comes while the output is being written.
interrupted() {
  local signal=$1 process status=0
  shift
  "$@" >"$work/output" 2>&1 &
  process=$!
  for ((i = 0; i < 500; i++)); do
    [ -z "$(find "$work" -name '*.part' -size +0)" ] || break
    sleep 0.01
  done
  kill "-$signal" "$process"
  wait "$process" || status=$?
  cat "$work/output"
  [ "$status" = 130 ] && leaves_nothing
}
track "$work/minutes.txt" 0 0.033333 1500
for signal in INT TERM; do
  promise "SIG$signal leaves nothing of a conversion" interrupted "$signal" \
    "$haptic_track" convert "$work/minutes.txt" "$work/minutes.wav"
  promise "nor of a cut" interrupted "$signal" \
    "$haptic_track" cut --with-video --from 1 "$work/recording.ts" "$work/interrupted.ts"
done
# A limit of the file size is an error like a full disk.
full() { (ulimit -f 2000 && says 1 "$work/full.wav" "$@") && leaves_nothing && [ ! -e "$work/full.wav" ]; }
promise "nor does a full disk" full "$haptic_track" convert "$work/minutes.txt" "$work/full.wav"

# The options as other programs have them.
promise "-h is --help" says 0 "Usage" "$haptic_track" -h
# Each verb has its own options.
explained() {
  local verb line
  for verb in $("$haptic_track" --help | sed -n 's/^  \([a-z]*\)  .*/\1/p'); do
    "$haptic_track" "$verb" --help >"$work/help"
    for line in "Usage: haptic-track $verb \[OPTION" "Example: haptic-track $verb"; do
      grep -q "^$line" "$work/help" || { echo "$verb has no '$line'" && return 1; }
    done
  done
  [ "$verb" = package ]
}
promise "VERB --help has its usage and an example" explained
promise "also of a mode, in the place of a value" says 0 "--chunk=K" "$haptic_track" author --chunk --help
promise "an option of another verb is refused" says 1 "cut: Unknown option --jobs" "$haptic_track" cut --jobs 2 a b
promise "and one of another way to author" says 1 "author --plan: Unknown option --jobs" "$haptic_track" author --plan --jobs 2 a
promise "and one that needs the other way" says 1 "author: Unknown option --chunks" "$haptic_track" author --chunks 2 a
promise "and one that there is not" says 1 "cut: Unknown option --colour" "$haptic_track" cut --colour a b
promise "a verb that there is not is named before its options" says 1 "unknown command 'conver'" "$haptic_track" conver --force a b
promise "an option needs its value" says 1 "cut: Missing argument for --from" "$haptic_track" cut --from
promise "numbers have a range" says 1 "--places needs two numbers from 1 to 32, not '5x40'" "$haptic_track" compare --places 5x40 a b
promise "behind -- are files" says 1 '"--plan": there is no such file' "$haptic_track" author -- --plan
promise "a name may begin with a dash" says 1 '"-b.klv": there is no such file' "$haptic_track" info -- -b.klv
promise "--version is a version" says 0 "haptic-track " "$haptic_track" --version
promise "also behind a verb" says 0 "haptic-track " "$haptic_track" info --version
promise "--option=value" "$haptic_track" cut --from=0.1 --to=1 "$work/track.txt" "$work/part.txt"
promise "a flag takes no value" says 1 "--force takes no value" "$haptic_track" cut --force=1 "$work/track.txt" "$work/p.txt"
ffmpeg -v error -f lavfi -i testsrc2=size=352x288:rate=30:duration=1 -c:v libx264 -preset ultrafast "$work/short.mp4"
promise "author makes its folder" says 0 "1 written" "$haptic_track" author --output="$work/new/folder" "$work/short.mp4"
