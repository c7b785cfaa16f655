#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs the test program given on compressed clips of known motion, or on the videos in the folder FIELD_CLIPS.
set -euo pipefail

if [ -z "${FIELD_CLIPS:-}" ]; then
  FIELD_CLIPS=$(mktemp -d)
  trap 'rm -rf "$FIELD_CLIPS"' EXIT
  export FIELD_CLIPS
  for scene in leaf uniform:40,-20 halves:40,-60,-80,20; do
    "$MAKE_CLIP" 640 360 30 2 "$scene" |
      gst-launch-1.0 -q fdsrc ! rawvideoparse format=gray8 width=640 height=360 framerate=30/1 \
        ! videoconvert ! x264enc tune=zerolatency speed-preset=veryfast bitrate=4000 ! h264parse ! mp4mux ! filesink "location=$FIELD_CLIPS/${scene%%:*}.mp4"
  done
fi
"$1"
