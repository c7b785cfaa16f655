#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Send a video and its haptic track to another machine, whose hand points.
#
#   gst-launch-1.0 filesrc location=INPUT ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! clocksync ! roitracker ! pointerinject name=in ! tee name=t \
#       t. ! queue ! videoconvert ! video/x-raw,format=I420 ! x264enc tune=zerolatency key-int-max=30 \
#         ! rtph264pay config-interval=1 ! udpsink host=HOST port=5000 sync=false async=false \
#       t. ! queue ! velocityavg ! hapticconvert ! meta/x-klv ! rtpklvpay \
#         ! udpsink host=HOST port=5002 sync=false async=false \
#       udpsrc port=5004 caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M \
#         ! rtpklvdepay ! in.pointer
#
# Nothing is encrypted or signed: use it in a network that you trust, or through a tunnel.
#
# Usage: pipelines/send.sh [--to HOST] [--port PORT] INPUT
#   INPUT   a video file or URL, or --test-source: a live test video that moves to the left at 60 px/s
#   --to    the machine where receive.sh runs (127.0.0.1)
#   --port  UDP port of the video there (5000); the track uses PORT+2 there, the pointer PORT+4 here
#   Ctrl-C stops.

source "$(dirname "$0")/common.sh"

host=127.0.0.1 port=5000 video=''
while [ $# -gt 0 ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --to | --port)
    [ -n "${2:-}" ] || fail "$1 needs a value; see --help"
    [ "$1" = --to ] && host=$2 || port=$2
    shift
    ;;
  *) video=$1 ;;
  esac
  shift
done
[ -n "$video" ] || fail "which video? See --help"
[[ $port =~ ^[1-9][0-9]{0,4}$ ]] || fail "--port needs a number, not '$port'"
frames_of "$video"
elements=(roitracker velocityavg hapticconvert pointerinject)
need_packaged_elements x264enc rtph264pay rtpklvpay rtpklvdepay
[ "$has_sound" = no ] || echo "The sound of '$video' is not sent."

launch "${frames[@]}" ! roitracker ! pointerinject name=in ! tee name=t \
  t. ! queue ! "${h264[@]}" ! rtph264pay config-interval=1 \
  ! udpsink "host=$host" "port=$port" sync=false async=false \
  t. ! queue ! velocityavg ! hapticconvert ! meta/x-klv ! rtpklvpay \
  ! udpsink "host=$host" "port=$((port + 2))" sync=false async=false \
  udpsrc "port=$((port + 4))" caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M \
  ! rtpklvdepay ! in.pointer
