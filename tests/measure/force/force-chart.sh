#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws the force over time that hapticsink makes of a clip, and the force that a sink would make that holds
# each velocity until the next; and says how much each of them buzzes.
#
# Usage: tests/measure/force/force-chart.sh [CLIP] PICTURE.png
#   Without a CLIP a leaf swings in the wind for 20 s.
#
# Takes the programs from build/, which needs the option -Dtests=enabled.

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

case ${1:-} in
--help | -h) show_help && exit ;;
esac
[[ $# =~ ^[12]$ ]] || fail "there is no picture to write; name one, see --help"
picture=${*: -1}
trace=$build/tests/measure/force/force-trace
[ -x "$trace" ] ||
  fail "'$trace' is not built: meson configure $build -Dtests=enabled && meson compile -C $build"
use_elements
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

clip=$1
if [ $# = 1 ]; then
  clip=$work/leaf.mkv
  "$build/tests/make-clip" 352 288 30 20 leaf |
    gst-launch-1.0 -q fdsrc ! rawvideoparse format=gray8 width=352 height=288 framerate=30/1 \
      ! videoconvert ! jpegenc quality=95 ! matroskamux ! filesink "location=$clip"
fi
need_file "$clip"
gst-launch-1.0 -m filesrc "location=$(quoted "$clip")" ! decodebin ! videoconvert ! roitracker \
  ! velocityavg post-messages=true ! fakesink | "$trace" >"$work/trace.csv"
gnuplot -c "$root/tests/measure/force/force-chart.gp" "$work/trace.csv" "$picture"
echo "$picture"
