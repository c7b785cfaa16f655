#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Send a video and its haptic track as one MPEG transport stream over SRT; the hand at the other end points.
#
#   gst-launch-1.0 -e filesrc location=INPUT ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! clocksync ! roitracker ! pointerinject name=in ! tee name=t \
#       t. ! queue ! videoconvert ! video/x-raw,format=I420 ! x264enc tune=zerolatency key-int-max=30 \
#         ! h264parse config-interval=-1 ! queue ! mux. \
#       t. ! queue ! velocityavg ! hapticconvert ! meta/x-klv ! queue ! mux. \
#       mpegtsmux name=mux alignment=7 latency=100000000 \
#         ! srtsink uri=srt://:5020?mode=listener wait-for-connection=false passphrase=WORDS sync=false \
#       srtsrc uri=srt://:5022?mode=listener passphrase=WORDS keep-listening=true \
#         ! meta/x-klv,parsed=true ! in.pointer
#
# SRT repeats what is lost, and encrypts with the passphrase.
#
# Usage: pipelines/send-ts.sh [--port PORT] [--passphrase-file FILE] INPUT
#        pipelines/send-ts.sh --receive [--from HOST] [--port PORT] [--passphrase-file FILE] [--latency MS]
#            [-- OPTION=VALUE...]
#   INPUT         a video file or URL, or --test-source: a live test video that moves to the left at 60 px/s
#   --receive     show and feel what is sent
#   --from        the machine that sends (127.0.0.1)
#   --port        UDP port (5020), even; the pointer uses PORT+2
#   --latency     ms in which lost packets are repeated (125)
#   --passphrase-file  10 to 79 letters or digits in its first line, the same at both ends; without it nothing is
#                 encrypted. --passphrase WORDS shows them to other users of the machine.
#   What follows -- goes to hapticsink. Ctrl-C stops.

source "$(dirname "$0")/common.sh"
source "$(dirname "$0")/rtp.sh"

from=127.0.0.1 port=5020 passphrase='' latency=125 receives='' video=''
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --from | --port | --passphrase | --passphrase-file | --latency)
    [ -n "${2:-}" ] || fail "$1 needs a value; see --help"
    if [ "$1" = --passphrase-file ]; then
      need_file "$2"
      IFS= read -r passphrase <"$2" || true
      [ -n "$passphrase" ] || fail "'$2' has no passphrase in its first line"
    else
      printf -v "${1#--}" %s "$2"
    fi
    shift
    ;;
  --receive) receives=yes ;;
  *)
    [ -z "$video" ] || fail "one input only; see --help"
    video=$1
    ;;
  esac
  shift
done
need_rtp_port "$port"
[[ $latency =~ ^[0-9]{1,5}$ ]] || fail "--latency needs milliseconds, not '$latency'"
[[ $passphrase =~ ^([[:alnum:]]{10,79})?$ ]] || fail "the passphrase needs 10 to 79 letters or digits"
secret=$passphrase

# `srt ELEMENT PORT [OPTION...]`: sets $link. The sender of the video is the listener, so that a wrong passphrase is
# known at the receiver.
srt() {
  local side="listener"
  [ -z "$receives" ] || side="caller"
  link=("srt$1" "uri=$(quoted "srt://${receives:+$from}:$2?mode=$side")" ${secret:+passphrase=@secret@} "latency=$latency" "${@:3}")
}

# Passes the errors of the pipeline on, line by line, and adds one sentence to those of SRT. After Ctrl-C the pipeline
# still writes.
explain_errors() {
  local line cure=''
  trap '' INT
  while IFS= read -r line || [ -n "$line" ]; do
    printf '%s\n' "$line"
    if [[ $line = *'Incorrect passphrase'* ]]; then
      cure="the passphrase is not that of the sender; give the same at both ends"
    elif [ -z "$cure" ] && [[ $line =~ 'does not exist'|'imed out'|'imeout' ]]; then
      cure="nobody sends there, or the sender ended; start send-ts.sh there"
    fi
  done
  [ -z "$cure" ] || printf '%s: %s\n' "${0##*/}" "$cure"
}

if [ -n "$receives" ]; then
  [ -z "$video" ] || fail "an input is for the sender, not for --receive; see --help"
  read_arguments "$@"
  elements=(hapticconvert pointerextract hapticsink)
  need_packaged_elements tsdemux h264parse avdec_h264 srtsrc srtsink
  window=(fakesink sync=false async=false)
  ! has_display || window=("${live_window[@]}")
  srt src "$port" auto-reconnect=false
  stream=("${link[@]}" !)
  srt sink "$((port + 2))" auto-reconnect=false sync=false async=false
  pointer=("${link[@]}")
  exec 2> >(explain_errors >&2)
  launch "${stream[@]}" tsparse set-timestamps=true ! tsdemux latency=0 name=d \
    d. ! queue ! h264parse ! avdec_h264 ! videoconvert ! "${window[@]}" \
    d. ! meta/x-klv ! queue ! hapticconvert ! pointerextract name=p ! hapticsink "${sink_options[@]}" \
    p.pointer ! "${pointer[@]}"
fi

[ $# -eq 0 ] || fail "options of hapticsink go with --receive; see --help"
[ -n "$video" ] || fail "which video? See --help"
frames_of "$video"
elements=(roitracker velocityavg hapticconvert pointerinject)
need_packaged_elements x264enc h264parse mpegtsmux srtsink srtsrc
[ "$has_sound" = no ] || echo "The sound of '$video' is not sent."
srt sink "$port" wait-for-connection=false sync=false
stream=("${link[@]}")
srt src "$((port + 2))" keep-listening=true
pointer=("${link[@]}" ! "meta/x-klv,parsed=true")

# mpegtsmux waits for the encoder for 100 ms.
launch "${frames[@]}" ! roitracker ! pointerinject name=in ! tee name=t \
  t. ! queue ! "${h264[@]}" ! h264parse config-interval=-1 ! queue ! mux. \
  t. ! queue ! velocityavg ! hapticconvert ! meta/x-klv ! queue ! mux. \
  mpegtsmux name=mux alignment=7 latency=100000000 ! "${stream[@]}" \
  "${pointer[@]}" ! in.pointer
