#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Shows a video in a window, with motion and force drawn over it and curves of both below. The mouse points; the
# simulated device computes the force. The first run installs Debian packages and builds the plugins.
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! roitracker pointer-source=navigation ! tee name=t \
#       t. ! queue max-size-buffers=1 ! videoconvert ! hapticoverlay ! gtksink \
#       t. ! queue max-size-buffers=1 ! velocityavg post-messages=true ! hapticsink device=sim
#
# Keys: space pause, - slower, + faster, r reverse, [ and ] smaller and larger region, 0 default size,
# < weaker, > stronger (alpha), l next force law, s force off and on, q quit. At its end a file starts again.
#
# Usage: pipelines/view.sh [--verbose] [FILE | --camera [DEVICE] | --test-source] [-- OPTION=VALUE...]
#   FILE           a video (default: the film of the demonstration)
#   --camera       a camera (default: /dev/video0)
#   --test-source  a live test video that moves to the left at 60 px/s
#   --verbose      prints when the first frame was shown and what each key did
#   What follows -- goes to hapticsink. With device=... (usb, auto) that device points, not the mouse.

source "$(dirname "$0")/common.sh"
source "$(dirname "$0")/packages.sh"

verbose=() kind=file
if [ "${1:-}" = --verbose ]; then
  verbose=(--verbose)
  shift
fi
case ${1:-} in
--camera | --test-source)
  kind=${1#--}
  shift
  ;;
esac
read_arguments "$@"

case $kind in
test-source) frames=("${test_source[@]}" ! "${camera_frames[@]}") ;;
camera)
  need_camera "${input:=/dev/video0}"
  frames=(v4l2src "device=$(quoted "$input")" ! "${camera_frames[@]}")
  ;;
file)
  [ -z "$input" ] || is_url "$input" || need_file "$input"
  ;;
esac
need_display

pointer=navigation
case " ${sink_options[*]}" in
*' device='*) pointer=auto ;;
esac

# Installs packages and builds, unless FEELING_WIND_BUILD names a finished build.
set_up() {
  [ -z "${FEELING_WIND_BUILD:-}" ] ||
    fail "feeling-wind-view is not in the build '$build'; as root run: apt-get install ${view_packages[*]}, then build again"
  install_packages "${run_packages[@]}" "${build_packages[@]}" "${view_packages[@]}"
  if [ -f "$build/build.ninja" ]; then # configured before the packages were installed
    meson setup --reconfigure "$build" >"$build/build.log" 2>&1 || build_failed "$build/build.log"
  fi
  build_plugins
}

program=$build/pipelines/view/feeling-wind-view
[ -x "$program" ] || program=$(command -v feeling-wind-view) || { set_up && program=$build/pipelines/view/feeling-wind-view; }
use_elements hapticoverlay
if [ "$kind" = file ]; then
  default_to_wind_film
  need_video "$input"
  frames=("${film[@]}")
fi

line=("${frames[@]}" ! roitracker "pointer-source=$pointer" ! tee name=t
  t. ! queue max-size-buffers=1 ! videoconvert ! hapticoverlay ! gtksink
  t. ! queue max-size-buffers=1 ! velocityavg post-messages=true ! hapticsink device=sim "${sink_options[@]}")
show_line "${program##*/}" "${line[@]}"
exec "$program" "${verbose[@]}" "${line[@]}"
