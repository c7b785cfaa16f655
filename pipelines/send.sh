#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Send a video and its haptic track to another machine, whose hand points.
#
# Usage: pipelines/send.sh [--to HOST] [--port PORT] [--track KIND] [--sdp FILE [--srtp]] INPUT
#   INPUT    a video file or URL, or --test-source: a live test video that moves to the left at 60 px/s
#   --to     the machine where receive.sh runs (127.0.0.1)
#   --port   UDP port of the video there (5000), even. The track uses PORT+2 there, the pointer PORT+4 here, and RTCP
#            uses the odd ports up to PORT+7
#   --track  point (default): the motion under the pointer; hmpg: the same as MPEG haptics; field: the motion of the
#            whole frame, in which each hand selects its own place
#   --sdp    writes a description (RFC 8866) into FILE, which receive.sh and other players read
#   --srtp   encrypts and signs (RFC 3711) with a new key. The key is in FILE, which only you can read: copy FILE in
#            secret. The sender does not hear of losses, and a receiver must start within the first 65536 packets
#            (a quarter of an hour or more).
#   Ctrl-C stops.
#
# Example:
#   pipelines/send.sh --to 192.0.2.8 in.mp4
#
# The line that it runs:
#
#   gst-launch-1.0 -e rtpbin name=rtp rtp-profile=avpf rtcp-sync-send-time=false \
#       filesrc location=INPUT ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! clocksync ! roitracker ! pointerinject name=in ! tee name=t \
#       t. ! queue ! videoconvert ! video/x-raw,format=I420 ! x264enc tune=zerolatency key-int-max=30 \
#         ! rtph264pay pt=96 config-interval=-1 ! rtp.send_rtp_sink_0 \
#       t. ! queue ! velocityavg ! hapticconvert ! meta/x-klv ! rtpklvpay pt=97 ! rtp.send_rtp_sink_1 \
#       rtp.send_rtp_src_0 ! udpsink host=HOST port=5000 sync=false async=false \
#       rtp.send_rtcp_src_0 ! identity sleep-time=100000 ! udpsink host=HOST port=5001 sync=false async=false \
#       rtp.send_rtp_src_1 ! udpsink host=HOST port=5002 sync=false async=false \
#       rtp.send_rtcp_src_1 ! identity sleep-time=100000 ! udpsink host=HOST port=5003 sync=false async=false \
#       udpsrc port=5005 ! rtp.recv_rtcp_sink_0  udpsrc port=5007 ! rtp.recv_rtcp_sink_1 \
#       udpsrc port=5004 caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M \
#         ! rtpklvdepay ! in.pointer
#
# RTCP keeps picture and force in step, and asks for a key frame after a loss. Without --srtp nothing is encrypted or
# signed: use it in a network that you trust, or through a tunnel.

source "$(dirname "$0")/shared/common.sh"
source "$(dirname "$0")/shared/rtp.sh"

to=127.0.0.1 port=5000 track=point sdp='' srtp='' key=''
read_options 'to= port= track= sdp= srtp --test-source' "$@"
[ ${#inputs[@]} -le 1 ] || fail "there is more than one input; give one, see --help"
video=${inputs[0]:-} host=$to
[ -z "$srtp" ] || key=$(head -c 30 /dev/urandom | base64)
[ -n "$video" ] || fail "there is no video to send; name one, see --help"
need_rtp_port "$port"
[ -z "$key" ] || [ -n "$sdp" ] || fail "--srtp needs --sdp: the receiver gets the key from that file"
[ -z "$key" ] || hide_key
frames_of "$video"
elements=(roitracker velocityavg motionfield hapticconvert pointerinject)
need_packaged_elements rtpbin x264enc rtph264pay rtpklvpay rtpklvdepay
[ "$has_sound" = no ] || echo "The sound of '$video' is not sent."

tracker=(roitracker !)
case $track in
point) motion=(velocityavg ! hapticconvert ! meta/x-klv ! rtpklvpay pt=97) ;;
hmpg) motion=(velocityavg ! hapticconvert ! haptics/hmpg ! rtphmpgpay aggregate=true pt=115) ;;
field) tracker=() motion=(motionfield ! hapticconvert ! meta/x-klv ! rtpklvpay pt=97) ;;
*) fail "--track is point, hmpg or field, not '$track'" ;;
esac
random_number() { od -An -N4 -tu4 /dev/urandom | tr -d ' '; }
video_ssrc=$(random_number) track_ssrc=$(random_number) pointer_ssrc=$(random_number)
# An empty file, or another description.
may_be_replaced() {
  [ -f "$1" ] && [ ! -L "$1" ] && { [ ! -s "$1" ] || [ "$(head -c 3 "$1" | tr -d '\0')" = v=0 ]; }
}
if [ -n "$sdp" ]; then
  [ ! -e "$sdp" ] || may_be_replaced "$sdp" || fail "'$sdp' exists and is no description (SDP); give another name"
  rm -f "$sdp"
  [ -z "$key" ] || umask 077 # the key is in it
  write_sdp >"$sdp" || fail "'$sdp' cannot be written; give another name"
fi

# `sent SESSION PORT`: the packets of one session go to the receiver. rtpsession ends the stream of RTCP if its thread
# finds, after the last report, the end of the stream noted; this thread waits a little, so that it is.
there=("host=$(quoted "$host")" sync=false async=false)
sent() {
  local rtp=() rtcp=()
  [ -z "$key" ] || rtp=(srtp."rtp_sink_$1" srtp."rtp_src_$1" !) rtcp=(srtp."rtcp_sink_$1" srtp."rtcp_src_$1" !)
  ways+=(rtp."send_rtp_src_$1" ! "${rtp[@]}" udpsink "port=$2" "${there[@]}")
  ways+=(rtp."send_rtcp_src_$1" ! identity sleep-time=100000 ! "${rtcp[@]}" udpsink "port=$(($2 + 1))" "${there[@]}")
}
ways=()
sent 0 "$port"
sent 1 "$((port + 2))"
if [ -n "$key" ]; then
  need_packaged_elements srtpenc srtpdec
  ways+=(srtpenc name=srtp key=@secret@ udpsrc "port=$((port + 4))" "caps=$(srtp_caps "$rtp_klv" "$pointer_ssrc")" ! srtpdec)
else
  ways+=(udpsrc "port=$((port + 5))" ! rtp.recv_rtcp_sink_0 udpsrc "port=$((port + 7))" ! rtp.recv_rtcp_sink_1
    udpsrc "port=$((port + 4))" "caps=$rtp_klv")
fi

launch rtpbin name=rtp rtp-profile=avpf rtcp-sync-send-time=false \
  "${frames[@]}" ! "${tracker[@]}" pointerinject name=in ! tee name=t \
  t. ! queue ! "${h264[@]}" ! rtph264pay pt=96 "ssrc=$video_ssrc" config-interval=-1 ! rtp.send_rtp_sink_0 \
  t. ! queue ! "${motion[@]}" "ssrc=$track_ssrc" ! rtp.send_rtp_sink_1 \
  "${ways[@]}" ! rtpklvdepay ! in.pointer
