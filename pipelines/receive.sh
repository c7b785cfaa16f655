#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Show and feel the video that another machine sends with send.sh; the hand here points.
#
#   gst-launch-1.0 -e udpsrc port=5000 caps=application/x-rtp,media=video,clock-rate=90000,encoding-name=H264 \
#         ! rtpjitterbuffer latency=30 ! rtph264depay ! avdec_h264 ! videoconvert ! autovideosink \
#       udpsrc port=5002 caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M \
#         ! rtpjitterbuffer latency=30 ! rtpklvdepay ! hapticconvert ! pointerextract name=p ! hapticsink \
#       p.pointer ! rtpklvpay ! udpsink host=HOST port=5004 sync=false async=false
#
# Without a display the video is not shown. No track from the network exceeds hapticsink's max-force.
#
# Usage: pipelines/receive.sh [--from HOST] [--port PORT] [--latency MS] [-- OPTION=VALUE...]
#   --from     the machine where send.sh runs (127.0.0.1)
#   --port     UDP port of the video (5000), as in send.sh
#   --latency  ms to wait for late or reordered packets (30)
#   What follows -- goes to hapticsink. Ctrl-C stops.

source "$(dirname "$0")/common.sh"

host=127.0.0.1 port=5000 latency=30
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --from | --port | --latency)
    [ -n "${2:-}" ] || fail "$1 needs a value; see --help"
    case $1 in
    --from) host=$2 ;;
    --port) port=$2 ;;
    --latency) latency=$2 ;;
    esac
    shift
    ;;
  *) fail "unknown option '$1'; see --help" ;;
  esac
  shift
done
[[ $port =~ ^[1-9][0-9]{0,4}$ ]] || fail "--port needs a number, not '$port'"
[[ $latency =~ ^[0-9]{1,5}$ ]] || fail "--latency needs milliseconds, not '$latency'"
read_arguments "$@"
elements=(hapticconvert pointerextract hapticsink)
need_packaged_elements rtph264depay rtpklvdepay avdec_h264

window=(fakesink sync=false)
! has_display || window=(autovideosink)
launch udpsrc "port=$port" caps=application/x-rtp,media=video,clock-rate=90000,encoding-name=H264 \
  ! rtpjitterbuffer "latency=$latency" ! rtph264depay ! avdec_h264 ! videoconvert ! "${window[@]}" \
  udpsrc "port=$((port + 2))" caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M \
  ! rtpjitterbuffer "latency=$latency" ! rtpklvdepay ! hapticconvert ! pointerextract name=p \
  ! hapticsink "${sink_options[@]}" \
  p.pointer ! rtpklvpay ! udpsink "host=$host" "port=$((port + 4))" sync=false async=false
