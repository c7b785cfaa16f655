#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws how a stroke runs over an array of actuators: the amplitude of each over time.
#
# Usage: pipelines/paper/array-picture.sh OUT.png [LAYOUT [VIDEO]]
#   LAYOUT  a layout of hapticarray (default: back-3x4)
#   VIDEO   a video, of which 360 frames are used (default: the film of the demonstration)
#
# Example:
#   pipelines/paper/array-picture.sh array.png ring-8
#
# The line that it runs:
#
#   ... ! motionfield ! hapticarray ! audio/x-raw,rate=8000 ! filesink

source "$(dirname "$0")/../shared/common.sh"
source "$(dirname "$0")/../shared/packages.sh"

case ${1:---help} in --help | -h) show_help && exit ;; esac
out=$1 layout=${2:-back-3x4} video=${3:-} rate=8000
command -v gnuplot >/dev/null || fail "gnuplot is missing; install the package gnuplot-nox"
use_elements motionfield hapticarray
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

[ -z "$video" ] || need_video "$video"
decoding "${video:-$(wind_film)}"
gst-launch-1.0 -v "${film[@]}" ! identity eos-after=360 ! videoconvert \
  ! motionfield ! hapticarray "layout=$layout" pointer-x=0.45 pointer-y=0.4 "alpha=$wind_alpha" \
  ! "audio/x-raw,rate=$rate" ! filesink "location=$work/sound.f32" >"$work/caps"
channels=$(sed -n 's/.*audio.x-raw.*channels=(int)\([0-9]*\).*/\1/p' "$work/caps" | head -n 1)
# The highest of each 20 ms.
od -An -v -t f4 -w$((4 * channels)) "$work/sound.f32" | awk -v "step=$((rate / 50))" '
  { for (i = 1; i <= NF; i++) { a = $i < 0 ? -$i : $i; if (a > most[i]) most[i] = a } }
  NR % step == 0 { for (i = 1; i <= NF; i++) { print (NR / step - 0.5) / 50, i, most[i]; most[i] = 0 }; print "" }
' >"$work/amplitudes"
gnuplot -e "load '$root/pipelines/shared/palette.gp'; amplitudes='$work/amplitudes'; out='$out'; channels=$channels" \
  "$root/pipelines/paper/array-picture.gp"
