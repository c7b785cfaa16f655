#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Several haptic tracks in one file: each is named, and one is chosen. A track of another film: what can be known is
# said.

source "$(dirname "$0")/support.sh"

# `recorded NAME SCENE`: a recording of three seconds, $work/NAME.ts.
recorded() {
  clip "$work/$1.mkv" 352 288 30 3 "$2"
  "$root/pipelines/record.sh" "$work/$1.mkv" "$work/$1.ts" -- device=sim
}
promise "a video is recorded" recorded right uniform:60,0
promise "and another" recorded up uniform:0,-100

gst-launch-1.0 -q mpegtsmux name=mux ! filesink "location=$work/two.ts" \
  filesrc "location=$work/right.ts" ! tsdemux ! meta/x-klv ! queue ! mux.sink_65 \
  filesrc "location=$work/up.ts" ! tsdemux ! meta/x-klv ! queue ! mux.sink_66
gst-launch-1.0 -q matroskamux name=mux ! filesink "location=$work/two.mkv" \
  filesrc "location=$work/right.ts" ! tsdemux ! meta/x-klv ! hapticconvert ! text/x-raw ! queue ! mux.subtitle_0 \
  filesrc "location=$work/up.ts" ! tsdemux ! meta/x-klv ! hapticconvert ! text/x-raw ! queue ! mux.subtitle_1
# `moves FILE STREAM VX VY [WITHIN]`: the tenth sample of the track moves so, within 2 px/s.
moves() {
  haptic_track convert --force --stream "$2" "$1" "$work/one.txt" || return 1
  sed -n '10s/.* vx=\([^ ]*\) vy=\([^ ]*\) .*/\1 \2/p' "$work/one.txt" |
    awk -v "x=$3" -v "y=$4" -v "within=${5:-2}" '{ print; exit !(($1 - x) ^ 2 + ($2 - y) ^ 2 < within ^ 2) }'
}
for ending in ts mkv; do
  about=$(haptic_track info "$work/two.$ending")
  first=$(sed -n 's/^  stream  *//p' <<<"$about")
  second=$(sed -n 's/^  another  *//p' <<<"$about")
  promise "both tracks of one .$ending are named" test -n "$first" -a -n "$second" -a "$first" != "$second"
  [ "$ending" = mkv ] || [ "$first" = private_0_0041 ] || { swap=$first first=$second second=$swap; }
  promise "one is chosen" moves "$work/two.$ending" "$first" 60 0
  promise "and the other" moves "$work/two.$ending" "$second" 0 -100
done
refused() {
  ! haptic_track info --stream audio_0 "$work/two.mkv" 2>"$work/stderr" && grep -q "is not a haptic track, but $first is" "$work/stderr"
}
promise "a stream that is none is refused" refused
promise "the second is played" \
  "$root/pipelines/play-track.sh" --stream "$second" "$work/two.mkv" -- device=sim "log-location=$work/log.csv"
read -r up_x up_y < <(force_of 0 -100)
promise "and felt" felt "$work/log.csv" "$up_x" "$up_y"

# A part of a film has the track that was chosen, and no other.
gst-launch-1.0 -q mpegtsmux name=mux ! filesink "location=$work/both.ts" \
  filesrc "location=$work/right.ts" ! tsdemux ! meta/x-klv ! queue ! mux.sink_65 \
  filesrc "location=$work/up.ts" ! tsdemux ! meta/x-klv ! queue ! mux.sink_66 \
  videotestsrc num-buffers=90 ! video/x-raw,width=352,height=288,framerate=30/1 ! x264enc key-int-max=15 tune=zerolatency \
  ! h264parse ! queue ! mux.sink_67
promise "a part is cut with one of two tracks" haptic_track cut --with-video --from 0.6 --to 2 --stream private_0_0042 \
  "$work/both.ts" "$work/part.ts"
about=$(haptic_track info "$work/part.ts")
promise "which is the only one there" test "$(grep -cE '^  (stream|another) ' <<<"$about")" = 1
promise "and is that one" moves "$work/part.ts" "$(sed -n 's/^  stream  *//p' <<<"$about")" 0 -100 5

# The track of another film.
gst-launch-1.0 -q matroskamux name=mux ! filesink "location=$work/wrong.mkv" \
  filesrc "location=$work/right.ts" ! tsdemux ! meta/x-klv ! hapticconvert ! text/x-raw ! queue ! mux. \
  videotestsrc num-buffers=30 ! video/x-raw,width=160,height=120,framerate=30/1 ! jpegenc ! queue ! mux.
about=$(haptic_track info "$work/wrong.mkv")
promise "a track that is longer than its film is remarked" grep -q 'goes on for [12]\.. s after the film' <<<"$about"
promise "so is one of another frame" grep -q 'in frames of 352 x 288 px, and the film beside it has 160 x 120' <<<"$about"
promise "and not the right one" test -z "$(haptic_track info "$work/right.ts" | grep remark)"
