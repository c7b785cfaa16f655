#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Show and feel the video that another machine sends with send.sh; the hand here points.
#
# Usage: pipelines/receive.sh [--from HOST] [--port PORT] [--sdp FILE] [--latency MS] [-- OPTION=VALUE...]
#   --from     the machine where send.sh runs (127.0.0.1)
#   --port     UDP port of the video (5000), as in send.sh
#   --sdp      the file that send.sh --sdp wrote: port, kind of track, key
#   --latency  how long to wait for late or reordered packets, in ms (30)
#   What follows -- goes to hapticsink. Ctrl-C stops.
#
# Example:
#   pipelines/receive.sh --from 192.0.2.7 -- device=sim
#
# The line that it runs:
#
#   gst-launch-1.0 -e rtponesender name=rtp latency=30 \
#       udpsrc port=5000 caps=application/x-rtp,media=video,clock-rate=90000,encoding-name=H264,payload=96 \
#         ! rtp.recv_rtp_sink_0  udpsrc port=5001 ! rtp.recv_rtcp_sink_0 \
#       udpsrc port=5002 caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M,payload=97 \
#         ! rtp.recv_rtp_sink_1  udpsrc port=5003 ! rtp.recv_rtcp_sink_1 \
#       rtp.send_rtcp_src_0 ! udpsink host=HOST port=5005 sync=false async=false \
#       rtp.send_rtcp_src_1 ! udpsink host=HOST port=5007 sync=false async=false \
#       rtp.recv_rtp_src_0 ! rtph264depay ! avdec_h264 ! videoconvert ! autovideosink \
#       rtp.recv_rtp_src_1 ! rtpklvdepay ! hapticconvert ! pointerextract name=p ! hapticsink \
#       p.pointer ! rtpklvpay pt=97 ! udpsink host=HOST port=5004 sync=false async=false
#
# Without a display the script does not show the video. No track from the network exceeds hapticsink's max-force.

source "$(dirname "$0")/shared/common.sh"
source "$(dirname "$0")/shared/rtp.sh"

from=127.0.0.1 port=5000 latency=30 track=point key='' sdp=''
read_options 'from= port= latency= sdp= --' "$@"
[ ${#inputs[@]} = 0 ] || fail "unknown option '${inputs[0]}'; see --help"
host=$from
[ -z "$sdp" ] || read_sdp "$sdp"
[ -z "$key" ] || hide_key
need_rtp_port "$port"
[[ $latency =~ ^[0-9]{1,5}$ ]] || fail "--latency needs milliseconds, not '$latency'"
elements=(rtponesender hapticconvert pointerextract hapticsink)
need_packaged_elements rtpbin rtph264depay rtpklvdepay avdec_h264

depay=rtpklvdepay track_caps=$rtp_klv
[ "$track" != hmpg ] || depay=rtphmpgdepay track_caps=$rtp_hmpg

# `received SESSION PORT CAPS SSRC`: the packets of one session, and reports about them to the sender.
back=("host=$(quoted "$host")" sync=false async=false)
received() {
  if [ -z "$key" ]; then
    ways+=(udpsrc "port=$2" "caps=$3" ! rtp."recv_rtp_sink_$1" udpsrc "port=$(($2 + 1))" ! rtp."recv_rtcp_sink_$1"
      rtp."send_rtcp_src_$1" ! udpsink "port=$(($2 + 5))" "${back[@]}")
  else
    ways+=(srtpdec "name=srtp$1" udpsrc "port=$2" "caps=$(srtp_caps "$3" "$4")" ! srtp"$1".rtp_sink
      srtp"$1".rtp_src ! rtp."recv_rtp_sink_$1"
      udpsrc "port=$(($2 + 1))" "caps=$(srtp_caps application/x-rtcp "$4")" ! srtp"$1".rtcp_sink
      srtp"$1".rtcp_src ! rtp."recv_rtcp_sink_$1")
  fi
}
ways=()
received 0 "$port" "$rtp_video" "${video_ssrc:-}"
received 1 "$((port + 2))" "$track_caps" "${track_ssrc:-}"
pointer=(rtpklvpay pt=97)
if [ -n "$key" ]; then
  need_packaged_elements srtpenc srtpdec
  pointer+=("ssrc=$pointer_ssrc" ! srtp.rtp_sink_0 srtpenc name=srtp key=@secret@ srtp.rtp_src_0)
fi

# The force does not wait for the first frame that can be decoded.
window=(fakesink sync=false async=false)
! has_display || window=("${live_window[@]}")
launch rtponesender name=rtp "latency=$latency" "${ways[@]}" \
  rtp.recv_rtp_src_0 ! rtph264depay request-keyframe=true ! avdec_h264 ! videoconvert ! "${window[@]}" \
  rtp.recv_rtp_src_1 ! "$depay" ! hapticconvert ! pointerextract name=p ! hapticsink "${sink_options[@]}" \
  p.pointer ! "${pointer[@]}" ! udpsink "port=$((port + 4))" "${back[@]}"
