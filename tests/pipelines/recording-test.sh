#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A video is recorded with its track while it is felt, and the recording is felt alike without a tracker.

source "$(dirname "$0")/support.sh"

clip "$work/in.mkv" 352 288 30 3 uniform:60,0

read -r fx fy < <(force_of 60 0)

for ending in ts mkv; do
  recording=$work/session.$ending
  promise "a video is recorded into .$ending" \
    "$root/pipelines/record.sh" "$work/in.mkv" "$recording" -- device=sim "log-location=$work/log.csv"
  promise "and felt while it is" felt "$work/log.csv" "$fx" "$fy"
  promise "haptic-track says what is inside" \
    grep -q '^  samples    90$' <(haptic_track info "$recording")
  promise "the recording plays without a tracker" \
    "$root/pipelines/play-track.sh" "$recording" -- device=sim "log-location=$work/log.csv"
  promise "and is felt as the video was" felt "$work/log.csv" "$fx" "$fy"
done

# 5 % of this velocity is less than 2 % of the largest force.
for ending in klv txt hmpg hjif; do
  promise "the track alone is written as .$ending" \
    haptic_track convert "$work/session.ts" "$work/track.$ending"
  promise "and plays" "$root/pipelines/play-track.sh" "$work/track.$ending" -- device=sim sync=false
  promise "and is converted back" haptic_track convert --force "$work/track.$ending" "$work/samples.txt"
  mv "$work/samples.txt" "$work/samples"
  promise "with the motion of the video" measured "(vx - 60) ^ 2 + vy ^ 2 < (0.05 * 60) ^ 2"
done

# A track of a minute, whose script is killed.
awk 'BEGIN {
  for (i = 0; i < 1500; i++)
    printf "hv1 point t=%.2f d=0.04 i=0.04 vx=60 vy=0 spin=0 div=0 x=0.5 y=0.5 w=0.1 h=0.1 conf=1 pic=352x288 par=1:1 " \
      "n=17 model=translation\n", i / 25
}' >"$work/minute.txt"
sed -n 1,250p "$work/minute.txt" | awk '{ sub(/t=[0-9.]*/, sprintf("t=%.2f", 12 + NR / 25)); print }' >"$work/late.txt"
for ending in ts mkv; do
  haptic_track convert "$work/late.txt" "$work/late.$ending"
  promise "a track alone has the times of its sender in .$ending" \
    grep -q "^  time       12.040 to 22.000 s" <(haptic_track info "$work/late.$ending")
  promise "and is no later" haptic_track compare --at-most 0 "$work/late.txt" "$work/late.$ending"
done
ends_with_its_script() {
  local script player
  "$root/pipelines/play-track.sh" "$work/minute.txt" -- device=sim "log-location=$work/minute.csv" >/dev/null 2>&1 &
  script=$!
  until [ -s "$work/minute.csv" ]; do
    kill -0 $script || return 1
    sleep 0.1
  done
  player=$(pgrep -P $script gst-launch) || return 1
  kill -TERM $script
  for _ in {1..100}; do
    kill -0 "$player" 2>/dev/null || return 0
    sleep 0.1
  done
  kill -KILL "$player"
  return 1
}
promise "no force is left behind by a script that is killed" ends_with_its_script

# `complains PATTERN COMMAND...`: fails with a message that matches.
complains() {
  local pattern=$1
  shift
  ! "$@" >/dev/null 2>"$work/stderr" && grep -qE "$pattern" "$work/stderr"
}

# Other KLV and subtitles stand before the track.
printf '1\n00:00:00,000 --> 00:00:01,000\nmy words\n' >"$work/words.srt"
LC_ALL=C sed 's/HAPTIC/OTHERS/g' "$work/session.ts" >"$work/other.ts"
other=(filesrc "location=$work/other.ts" ! tsdemux ! meta/x-klv)
words=(filesrc "location=$work/words.srt" ! subparse ! text/x-raw)
gst-launch-1.0 -q mpegtsmux name=mux ! filesink "location=$work/second.ts" "${other[@]}" ! mux.sink_65 \
  filesrc "location=$work/session.ts" ! tsdemux ! meta/x-klv ! mux.sink_66
gst-launch-1.0 -q matroskamux name=mux ! filesink "location=$work/second.mkv" "${words[@]}" ! mux.subtitle_0 \
  filesrc "location=$work/session.ts" ! tsdemux ! meta/x-klv ! hapticconvert ! text/x-raw ! mux.subtitle_1
gst-launch-1.0 -q "${other[@]}" ! mpegtsmux ! filesink "location=$work/none.ts"
gst-launch-1.0 -q "${words[@]}" ! matroskamux ! filesink "location=$work/none.mkv"
for ending in ts mkv; do
  promise "the track is found behind another in .$ending" \
    grep -q '^  samples    90$' <(haptic_track info "$work/second.$ending")
  promise "and none is not taken for one" complains 'no haptic track in this file, only' haptic_track info "$work/none.$ending"
done
gst-launch-1.0 -q matroskamux name=mux ! filesink "location=$work/film.mkv" "${words[@]}" ! queue ! mux.subtitle_0 \
  filesrc "location=$work/session.ts" ! tsdemux ! meta/x-klv ! hapticconvert ! text/x-raw ! queue ! mux.subtitle_1 \
  filesrc "location=$work/in.mkv" ! matroskademux ! jpegdec ! videoconvert ! vp8enc deadline=1 ! queue ! mux. \
  audiotestsrc num-buffers=129 ! audioconvert ! avenc_aac ! aacparse ! queue ! mux.
plays_film() {
  "$root/pipelines/play-track.sh" "$work/film.mkv" -- device=sim "log-location=$work/log.csv" >"$work/line" || return 1
  grep -q '! hapticconvert .* decodebin .* film\. .* autoaudiosink' "$work/line"
}
promise "a film with another codec and sound plays with its track" plays_film
promise "and is felt as the video was" felt "$work/log.csv" "$fx" "$fy"

# A film with sound, of one second.
clip "$work/silent.mkv" 352 288 30 1 uniform:60,0
gst-launch-1.0 -q matroskamux name=mux ! filesink "location=$work/sound.mkv" filesrc "location=$work/silent.mkv" \
  ! matroskademux ! queue ! mux. audiotestsrc num-buffers=43 ! audioconvert ! vorbisenc ! queue ! mux.
promise "a film with sound is recorded" "$root/pipelines/record.sh" "$work/sound.mkv" "$work/sound.ts" -- device=sim
promise "with its sound" grep -q Audio: <(ffmpeg -i "$work/sound.ts" 2>&1)
promise "and the track" grep -q samples <(haptic_track info "$work/sound.ts")
promise "as a film it plays" samples_of play-file.sh "$work/sound.ts"
promise "with its motion" measured "(vx - 60) ^ 2 + vy ^ 2 < (0.05 * 60) ^ 2"

no_player_shows_it() {
  ffprobe -v error -select_streams s -show_entries stream_disposition=default,forced -of csv=p=0 "$1" | grep -x 0,0
}
promise "no player shows the track as subtitles" no_player_shows_it "$work/session.mkv"

promise "a part is cut out" haptic_track cut --from 1 --to 2 "$work/session.ts" "$work/part.txt"
promise "with the samples of one second" test "$(wc -l <"$work/part.txt")" = 30
promise "a picture is drawn" haptic_track plot "$work/session.ts" "$work/plot.png"
promise "which is not empty" test -s "$work/plot.png"
promise "one that has no place is told" complains 'gnuplot|nowhere' haptic_track plot "$work/session.ts" /nowhere/plot.png
prints_no_picture() { [ -z "$(haptic_track plot "$work/session.ts" /nowhere/plot.png 2>/dev/null)" ]; }
promise "and does not go to the terminal" prints_no_picture

{ printf '\t\r\n' && cat "$work/track.hjif"; } >"$work/blanks.hjif"
promise "blanks before JSON do not matter" haptic_track info "$work/blanks.hjif"
printf 'hvis du vil hjem.\n' >"$work/words.txt"
promise "words are no track" complains 'no haptic track' haptic_track info "$work/words.txt"
LC_ALL=C sed 's/HAPTIC/OTHERS/g' "$work/track.klv" >"$work/others.klv"
promise "sets of others are none either" complains 'no sample' haptic_track info "$work/others.klv"

# By its first byte it could be JSON.
{ printf n && head -c 9999 /dev/urandom; } >"$work/noise.ts"
promise "noise is no track" complains 'no haptic track' haptic_track info "$work/noise.ts"
# 3 145 728 silent units of 9 bytes.
printf '\x0c\0\0\0\x10\0\0\0\0' >"$work/units"
for _ in {1..20}; do
  cat "$work/units" "$work/units" >"$work/twice"
  mv "$work/twice" "$work/units"
done
cat "$root/tests/data/golden.hmpg" "$work"/units{,,} >"$work/long.hmpg"
promise "a track of millions of samples is refused" complains 'more than 3000000 samples' haptic_track info "$work/long.hmpg"
promise "a video without a track is called so" complains 'no haptic track in this file, only' \
  haptic_track info "$work/in.mkv"
promise "an output that exists stays" complains 'exists' \
  haptic_track convert "$work/session.ts" "$work/part.txt"
promise "an unknown ending is refused" complains 'must end in' \
  haptic_track convert "$work/session.ts" "$work/x.mp4"
promise "a recording that exists stays" complains 'exists' \
  "$root/pipelines/record.sh" "$work/in.mkv" "$work/session.ts"
promise "play-track says that there is no track" complains 'no haptic track' \
  "$root/pipelines/play-track.sh" "$work/in.mkv"
