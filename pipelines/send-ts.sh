#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Send a video and its haptic track as one MPEG transport stream over SRT or RIST; the hand at the other end points.
#
# Usage: pipelines/send-ts.sh [--rist [--to HOST]] [--port PORT] [--passphrase-file FILE] INPUT
#        pipelines/send-ts.sh --receive [--rist] [--from HOST] [--port PORT] [--passphrase-file FILE] [--latency MS]
#            [-- OPTION=VALUE...]
#   INPUT         a video file or URL, or --test-source: a live test video that moves to the left at 60 px/s
#   --receive     show and feel what is sent
#   --rist        RIST in place of SRT, the same at both ends
#   --to          with --rist, the machine that receives (127.0.0.1). With SRT the receiver calls, and needs --from
#   --from        the machine that sends (127.0.0.1)
#   --port        UDP port (5020), even. The pointer uses PORT+2, and RIST also uses PORT+1
#   --latency     time in which lost packets are repeated, in ms (125)
#   --passphrase-file  a file with 10 to 79 letters or digits in its first line, the same at both ends. Without it
#                 nothing is encrypted. --passphrase WORDS also works, but other users of the machine see WORDS.
#   What follows -- goes to hapticsink. Ctrl-C stops.
#
# Examples:
#   pipelines/send-ts.sh in.mp4
#   pipelines/send-ts.sh --receive -- device=sim
#
# The line that it runs:
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
# SRT and RIST repeat lost packets. SRT encrypts with the passphrase; RIST (its simple profile) does not encrypt.
# With --rist: ! rtpmp2tpay ! ristsink address=HOST port=5020, and the pointer is RTP.

source "$(dirname "$0")/shared/common.sh"
source "$(dirname "$0")/shared/rtp.sh"

from=127.0.0.1 to='' port=5020 passphrase='' passphrase_file='' latency=125 receive='' rist=''
read_options 'from= to= port= passphrase= passphrase-file= latency= receive rist --test-source --' "$@"
[ ${#inputs[@]} -le 1 ] || fail "there is more than one input; give one, see --help"
video=${inputs[0]:-}
if [ -n "$passphrase_file" ]; then
  need_file "$passphrase_file"
  IFS= read -r passphrase <"$passphrase_file" || true
  [ -n "$passphrase" ] || fail "'$passphrase_file' has no passphrase in its first line; write 10 to 79 letters or digits there"
fi
need_rtp_port "$port"
[[ $latency =~ ^[0-9]{1,5}$ ]] || fail "--latency needs milliseconds, not '$latency'"
[[ $passphrase =~ ^([[:alnum:]]{10,79})?$ ]] || fail "the passphrase needs 10 to 79 letters or digits"
secret=$passphrase
if [ -n "$rist" ]; then
  [ -z "$secret" ] || fail "RIST does not encrypt: leave the passphrase out, or use SRT"
  launcher=launch.py
elif [ -n "$to" ]; then
  fail "--to needs --rist; with SRT leave it out, and name the sender at the receiver with --from"
fi

# `srt ELEMENT PORT [OPTION...]`: sets $link. The sender of the video is the listener, so that a wrong passphrase is
# known at the receiver.
srt() {
  local side="listener"
  need_packaged_elements srtsrc srtsink
  [ -z "$receive" ] || side="caller"
  link=("srt$1" "uri=$(quoted "srt://${receive:+$from}:$2?mode=$side")" ${secret:+passphrase=@secret@} "latency=$latency" "${@:3}")
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

if [ -n "$receive" ]; then
  [ -z "$video" ] || fail "an input is for the sender, not for --receive; see --help"
  elements=(hapticconvert pointerextract hapticsink)
  need_packaged_elements tsdemux h264parse avdec_h264
  window=(fakesink sync=false async=false)
  ! has_display || window=("${live_window[@]}")
  if [ -n "$rist" ]; then
    need_packaged_elements ristsrc rtpmp2tdepay rtpklvpay
    stream=(ristsrc "port=$port" "receiver-buffer=$latency" ! rtpmp2tdepay !)
    pointer=(rtpklvpay pt=97 ! udpsink "host=$from" "port=$((port + 2))" sync=false async=false)
  else
    srt src "$port" auto-reconnect=false
    stream=("${link[@]}" !)
    srt sink "$((port + 2))" auto-reconnect=false sync=false async=false
    pointer=("${link[@]}")
    exec 2> >(explain_errors >&2)
  fi
  launch "${stream[@]}" tsparse set-timestamps=true ! tsdemux latency=0 name=d \
    d. ! queue ! h264parse ! avdec_h264 ! videoconvert ! "${window[@]}" \
    d. ! meta/x-klv ! queue ! hapticconvert ! pointerextract name=p ! hapticsink "${sink_options[@]}" \
    p.pointer ! "${pointer[@]}"
fi

[ ${#sink_options[@]} = 0 ] || fail "options of hapticsink go with --receive; see --help"
[ -n "$video" ] || fail "there is no video to send; name one, see --help"
frames_of "$video"
elements=(roitracker velocityavg hapticconvert pointerinject)
need_packaged_elements x264enc h264parse mpegtsmux
[ "$has_sound" = no ] || echo "The sound of '$video' is not sent."
if [ -n "$rist" ]; then
  need_packaged_elements ristsink rtpmp2tpay rtpklvdepay
  stream=(rtpmp2tpay ! ristsink "address=${to:-127.0.0.1}" "port=$port")
  pointer=(udpsrc "port=$((port + 2))" "caps=$rtp_klv" ! rtpklvdepay)
else
  srt sink "$port" wait-for-connection=false sync=false
  stream=("${link[@]}")
  srt src "$((port + 2))" keep-listening=true
  pointer=("${link[@]}" ! "meta/x-klv,parsed=true")
fi

# mpegtsmux waits for the encoder for 100 ms.
launch "${frames[@]}" ! roitracker ! pointerinject name=in ! tee name=t \
  t. ! queue ! "${h264[@]}" ! h264parse config-interval=-1 ! queue ! mux. \
  t. ! queue ! velocityavg ! hapticconvert ! meta/x-klv ! queue ! mux. \
  mpegtsmux name=mux alignment=7 latency=100000000 ! "${stream[@]}" \
  "${pointer[@]}" ! in.pointer
