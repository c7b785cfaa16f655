#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Play a recording with its haptic track. Nothing is measured, and OpenCV is not needed.
#
#   gst-launch-1.0 filesrc location=FILE ! tsdemux name=d \
#       d. ! queue ! h264parse ! avdec_h264 ! videoconvert ! autovideosink \
#       d. ! meta/x-klv ! queue ! hapticconvert ! hapticsink
#
# Without a display the video is not shown; a file without video plays its track only.
#
# Usage: pipelines/play-track.sh FILE [-- OPTION=VALUE...]
#   FILE  a recording of record.sh, or a track: .ts, .mkv, .klv, .txt, .hmpg or .hjif
#   What follows -- goes to hapticsink. Ctrl-C stops.

source "$(dirname "$0")/common.sh"

read_arguments "$@"
need_file "$input"
elements=(hapticconvert hapticsink)
use_elements "${elements[@]}"
about=$(haptic_track info "$input") || exit 1

case $(head -n 1 <<<"$about") in
*'in MPEG-TS') demuxer=(tsdemux name=d) track=meta/x-klv ;;
*'in Matroska') demuxer=(matroskademux name=d) track=text/x-raw ;;
*)
  # A bare track has no time stamps; in a container it has.
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
  haptic_track convert "$input" "$folder/track.mkv"
  (launch filesrc "location=$folder/track.mkv" ! matroskademux \
    ! hapticconvert ! hapticsink "${sink_options[@]}")
  exit
  ;;
esac

video=()
if grep -q '^  beside it  video/x-h264' <<<"$about"; then
  window=(fakesink sync=true)
  ! has_display || window=(autovideosink)
  video=(d. ! queue ! h264parse ! avdec_h264 ! videoconvert ! "${window[@]}")
fi
launch filesrc "location=$(quoted "$input")" ! "${demuxer[@]}" \
  d. ! "$track" ! queue ! hapticconvert ! hapticsink "${sink_options[@]}" "${video[@]}"
