#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Send the motion of the whole frame to any number of receivers; each hand selects what it feels.
#
# Usage: pipelines/field-multicast.sh [--group ADDRESS] [--port PORT] [--interface NAME] INPUT
#        pipelines/field-multicast.sh --receive [--group ADDRESS] [--port PORT] [--interface NAME]
#            [--latency MS] [-- OPTION=VALUE...]
#   INPUT        a video file or URL, a camera such as /dev/video0, or --test-source: a live test video that moves to
#                the left at 60 px/s
#   --receive    feel what is sent
#   --group      multicast address (239.255.43.1)
#   --port       UDP port (5010)
#   --interface  network interface (lo: this machine only)
#   --latency    how long to wait for late or reordered packets, in ms (30)
#   What follows -- goes to hapticsink. Ctrl-C stops.
#
# Examples:
#   pipelines/field-multicast.sh in.mp4
#   pipelines/field-multicast.sh --receive -- device=sim
#
# The lines that it runs:
#
#   gst-launch-1.0 -e v4l2src device=/dev/video0 ! videoconvert ! motionfield ! hapticconvert ! meta/x-klv \
#       ! rtpklvpay ! udpsink host=239.255.43.1 port=5010 multicast-iface=lo auto-multicast=true sync=false async=false
#
#   gst-launch-1.0 -e rtponesender name=rtp latency=30 \
#       udpsrc address=239.255.43.1 port=5010 multicast-iface=lo auto-multicast=true \
#         caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M ! rtp.recv_rtp_sink_0 \
#       rtp.recv_rtp_src_0 ! rtpklvdepay ! hapticconvert ! hapticsink
#
# No pointer goes back, so a receiver costs the sender nothing. If two machines send, a hand feels the one that began.
# Nothing is encrypted or signed: use it in a network that you trust. No track from the network exceeds the max-force
# of hapticsink.

source "$(dirname "$0")/shared/common.sh"

group=239.255.43.1 port=5010 interface=lo latency=30 receive=''
read_options 'group= port= interface= latency= receive --test-source --' "$@"
[ ${#inputs[@]} -le 1 ] || fail "there is more than one input; give one, see --help"
video=${inputs[0]:-}
# RFC 2365: 239.0.0.0/8 is for private use.
[[ $group =~ ^239(\.[0-9]{1,3}){3}$ ]] || fail "--group needs an address from 239.0.0.0 to 239.255.255.255, not '$group'"
[[ $port =~ ^[1-9][0-9]{0,4}$ ]] || fail "--port needs a number, not '$port'"
[[ $latency =~ ^[0-9]{1,5}$ ]] || fail "--latency needs milliseconds, not '$latency'"
[ -e "/sys/class/net/$interface" ] ||
  fail "there is no network interface '$interface'; use one of: $(cd /sys/class/net && echo *)"

if [ -n "$receive" ]; then
  [ -z "$video" ] || fail "an input is for the sender, not for --receive; see --help"
  elements=(rtponesender hapticconvert hapticsink)
  need_packaged_elements rtpbin rtpklvdepay
  launch rtponesender name=rtp "latency=$latency" \
    udpsrc "address=$group" "port=$port" "multicast-iface=$interface" auto-multicast=true \
    caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M ! rtp.recv_rtp_sink_0 \
    rtp.recv_rtp_src_0 ! rtpklvdepay ! hapticconvert ! hapticsink "${sink_options[@]}"
fi

[ ${#sink_options[@]} = 0 ] || fail "options of hapticsink go with --receive; see --help"
[ -n "$video" ] || fail "there is no video to send; name one, see --help"
if [[ $video = /dev/* ]]; then
  need_camera "$video"
  frames=(v4l2src "device=$(quoted "$video")" ! "${camera_frames[@]}")
else
  frames_of "$video"
fi
elements=(motionfield hapticconvert)
need_packaged_elements rtpklvpay
launch "${frames[@]}" ! motionfield ! hapticconvert ! meta/x-klv ! rtpklvpay \
  ! udpsink "host=$group" "port=$port" "multicast-iface=$interface" auto-multicast=true sync=false async=false
