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

for ending in klv txt hmpg hjif; do
  promise "the track alone is written as .$ending" \
    haptic_track convert "$work/session.ts" "$work/track.$ending"
  promise "and plays" \
    "$root/pipelines/play-track.sh" "$work/track.$ending" -- device=sim "log-location=$work/log.csv"
  promise "and is felt as the video was" felt "$work/log.csv" "$fx" "$fy"
done

promise "a part is cut out" haptic_track cut --from 1 --to 2 "$work/session.ts" "$work/part.txt"
promise "with the samples of one second" test "$(wc -l <"$work/part.txt")" = 30
promise "a picture is drawn" haptic_track plot "$work/session.ts" "$work/plot.png"
promise "which is not empty" test -s "$work/plot.png"

# `complains PATTERN COMMAND...`: fails with a message that matches.
complains() {
  local pattern=$1
  shift
  ! "$@" >/dev/null 2>"$work/stderr" && grep -qE "$pattern" "$work/stderr"
}
head -c 10000 /dev/urandom >"$work/noise.ts"
promise "noise is no track" complains 'no haptic track' haptic_track info "$work/noise.ts"
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
