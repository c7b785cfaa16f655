#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A window with the video, what is measured and felt drawn over it, and a strip of velocity and force below.
# The mouse over the video points; the simulated device computes the force. Installs Debian packages and builds the
# plugins the first time.
#
#   gst-launch-1.0 filesrc location=FILE ! decodebin ! videoconvert \
#       ! roitracker pointer-source=navigation ! tee name=t \
#       t. ! queue max-size-buffers=1 ! videoconvert ! hapticoverlay ! gtksink \
#       t. ! queue max-size-buffers=1 ! velocityavg post-messages=true ! hapticsink device=sim
#
# Keys: space pause, - slower, + faster, r reverse, [ and ] smaller and larger region, 0 its usual size,
# l next force law, s force off and on again, q quit. A file begins anew at its end.
#
# Usage: pipelines/view.sh [--verbose] [FILE | --camera [DEVICE] | --test-source] [-- OPTION=VALUE...]
#   FILE           a video; the tree of the demonstration if nothing is given
#   --camera       a camera, /dev/video0 if none is named
#   --test-source  a live test picture that moves to the left at 60 px/s
#   --verbose      says when the first picture was shown and what the keys did
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
test-source) pictures=(videotestsrc is-live=true pattern=checkers-8 horizontal-speed=2
  ! "video/x-raw,width=352,height=288,framerate=30/1" ! "${camera_pictures[@]}") ;;
camera)
  need_camera "${input:=/dev/video0}"
  pictures=(v4l2src "device=$(quoted "$input")" ! "${camera_pictures[@]}")
  ;;
file)
  [ -n "$input" ] || input=$(tree_video)
  need_file "$input"
  pictures=(filesrc "location=$(quoted "$input")" ! decodebin ! videoconvert)
  ;;
esac
need_display

pointer=navigation
case " ${sink_options[*]}" in
*' device='*) pointer=auto ;;
esac

# Packages and build, unless the caller brought a finished build.
set_up() {
  [ -z "${FEELING_WIND_BUILD:-}" ] ||
    fail "feeling-wind-view is not in the build '$build'; as root run: apt-get install ${view_packages[*]}, then build again"
  install_packages "${run_packages[@]}" "${build_packages[@]}" "${view_packages[@]}"
  if [ -f "$build/build.ninja" ]; then # of a time without the packages
    meson setup --reconfigure "$build" >"$build/build.log" 2>&1 || build_failed "$build/build.log"
  fi
  build_plugins
}

program=$build/pipelines/view/feeling-wind-view
[ -x "$program" ] || program=$(command -v feeling-wind-view) || { set_up && program=$build/pipelines/view/feeling-wind-view; }
use_elements hapticoverlay

line=("${pictures[@]}" ! roitracker "pointer-source=$pointer" ! tee name=t
  t. ! queue max-size-buffers=1 ! videoconvert ! hapticoverlay ! gtksink
  t. ! queue max-size-buffers=1 ! velocityavg post-messages=true ! hapticsink device=sim "${sink_options[@]}")
show_line "${program##*/}" "${line[@]}"
exec "$program" "${verbose[@]}" "${line[@]}"
