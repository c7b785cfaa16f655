#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Play a recording with its haptic track. Nothing is measured, and OpenCV is not needed.
#
# Usage: pipelines/play-track.sh [--stream NAME] FILE [-- OPTION=VALUE...]
#   FILE      a recording of record.sh, or a track: .ts, .mkv, .mp4, .klv, .txt, .hmpg or .hjif
#   --stream  the track with this name, if haptic-track info shows several
#   What follows -- goes to hapticsink. Ctrl-C stops.
#
# Example:
#   pipelines/play-track.sh recorded.ts -- device=sim
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=FILE ! tsdemux ! meta/x-klv ! queue ! hapticconvert ! hapticsink \
#       filesrc location=FILE ! decodebin name=film ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#         ! queue ! videoconvert ! autovideosink \
#       film. ! queue ! audioconvert ! audioresample ! autoaudiosink
#
# Without a display the video is not shown; a file without video plays its track only.

source "$(dirname "$0")/shared/common.sh"

chosen=()
if [ "${1:-}" = --stream ]; then
  [ -n "${2:-}" ] || fail "--stream needs a value; see --help"
  chosen=(--stream "$2")
  shift 2
fi
read_arguments "$@"
need_file "$input"
elements=(hapticconvert hapticsink)
use_elements "${elements[@]}"
about=$(haptic_track info "${chosen[@]}" "$input") || exit 1
sed -nE "s/^  remark  *//p; s/^  another  *(.*)/There is another haptic track, to be chosen by --stream \1./p" <<<"$about" >&2

stream=$(sed -n 's/^  stream  *//p' <<<"$about")
if [ -z "$stream" ]; then
  # A bare track has no time stamps; in a container it has.
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
  haptic_track convert "$input" "$folder/track.mkv"
  # In small pieces: Ctrl-C ends the track behind what was read.
  (launch filesrc "location=$folder/track.mkv" blocksize=1024 ! queue max-size-buffers=1 ! matroskademux \
    ! hapticconvert ! hapticsink "${sink_options[@]}")
  exit
fi

demuxer=tsdemux
case $(head -n 1 <<<"$about") in
*'in Matroska') demuxer=matroskademux ;;
*'in MP4') demuxer=qtdemux ;;
esac
film=()
if grep -qE '^  beside it  (video|image)/' <<<"$about"; then
  need_packaged_elements deinterlace videoflip
  window=(fakesink sync=true)
  ! has_display || window=(autovideosink)
  decoding "$input" sound
  film+=(! queue ! videoconvert ! "${window[@]}")
  ! grep -q '^  beside it  audio/' <<<"$about" || film+=(film. ! queue ! audioconvert ! audioresample ! autoaudiosink)
fi
launch filesrc "location=$(quoted "$input")" ! $demuxer name=d \
  "d.$stream" ! queue ! hapticconvert ! hapticsink "${sink_options[@]}" "${film[@]}"
