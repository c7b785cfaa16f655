#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Record a video together with its haptic track into one file, while feeling it.
#
# Usage: pipelines/record.sh INPUT OUTPUT [-- OPTION=VALUE...]
#   INPUT   a video file or URL, or --test-source: a live test video that moves to the left at 60 px/s
#   OUTPUT  ends in .ts (MPEG-TS, the track as KLV) or .mkv (Matroska, the track as text)
#   What follows -- goes to hapticsink. Ctrl-C stops and completes the file.
#
# Example:
#   pipelines/record.sh in.mp4 recorded.ts -- device=sim
#
# The line that it runs:
#
#   gst-launch-1.0 -e filesrc location=INPUT ! decodebin name=film caps="video/x-raw(ANY);audio/x-raw(ANY)" \
#         expose-all-streams=false ! videoconvert ! deinterlace ! videoflip video-direction=auto ! clocksync \
#         ! roitracker ! tee name=t \
#       t. ! queue ! videoconvert ! video/x-raw,format=I420 ! x264enc tune=zerolatency key-int-max=30 \
#         ! h264parse ! queue ! mux. \
#       t. ! queue ! velocityavg ! tee name=h \
#       h. ! queue ! hapticconvert ! meta/x-klv ! mux. \
#       h. ! queue ! hapticsink \
#       film. ! queue ! audioconvert ! audioresample ! avenc_aac ! aacparse ! queue ! mux. \
#       mpegtsmux name=mux latency=1000000000 ! hapticmark ! filesink location=OUTPUT

source "$(dirname "$0")/shared/common.sh"

case ${1:-} in
'') fail "there is no video to record; name one, see --help" ;;
--help | -h) show_help && exit ;;
esac
video=$1
shift
read_arguments "$@"
[ -n "$input" ] || fail "there is no file to record into; name one, see --help"
case $input in
# mpegtsmux waits up to 1 s for the encoder. Otherwise the file would begin without the video stream, and a
# reader would take the track for another one when the video joins.
*.ts) track=meta/x-klv mux=(mpegtsmux latency=1000000000) ;;
*.mkv) track=text/x-raw mux=(matroskamux) ;;
*) fail "the name of the recording must end in .ts or .mkv, not '$input'" ;;
esac
[ ! -e "$input" ] || fail "'$input' exists; give another name, or remove it"
frames_of "$video" sound
elements=(roitracker velocityavg hapticconvert hapticmark hapticsink)
need_packaged_elements "${mux[0]}" x264enc h264parse
sound=()
if [ "$has_sound" = yes ]; then
  need_packaged_elements avenc_aac aacparse
  sound=(film. ! queue ! audioconvert ! audioresample ! avenc_aac ! aacparse ! queue ! mux.)
fi

launch "${frames[@]}" ! roitracker ! tee name=t \
  t. ! queue ! "${h264[@]}" ! h264parse ! queue ! mux. \
  t. ! queue ! velocityavg ! tee name=h \
  h. ! queue ! hapticconvert ! "$track" ! mux. \
  h. ! queue ! hapticsink "${sink_options[@]}" \
  "${sound[@]}" "${mux[@]}" name=mux ! hapticmark ! filesink "location=$(quoted "$input")"
