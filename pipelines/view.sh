#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Starts feeling-wind, the program for a person: a film in a window, with motion and force drawn over it and curves of
# both below. The mouse points; the simulated device computes the force. The first run installs Debian packages and
# builds the plugins. F1 in the window shows all keys.
#
# Usage: pipelines/view.sh [--verbose] [--array LAYOUT] [--array-sink SINK] [--touch TABLE]
#            [FILE | URL | --camera [DEVICE] | --test-source] [-- OPTION=VALUE...]
#   FILE           a video (default: the film of the demonstration)
#   --camera       a camera (default: /dev/video0)
#   --test-source  a live test video that moves to the left at 60 px/s
#   --verbose      prints when the first frame was shown and what each key did
#   --array        also drives an array of actuators: a layout of hapticarray
#   --array-sink   the sound device of the array, as a sink of gst-launch-1.0 (default: autoaudiosink)
#   --touch        lets a hand that has depth touch the colours: a table of reliefmap
#   What follows -- goes to hapticsink. With device=usb or device=auto the device points, and
#   not the mouse.
#
# Example:
#   pipelines/view.sh in.mp4 -- max-force=0.5

source "$(dirname "$0")/shared/common.sh"
source "$(dirname "$0")/shared/packages.sh"

arguments=() kind=file
while :; do
  case ${1:-} in
  --verbose) arguments+=("$1") && shift ;;
  --array | --array-sink | --touch)
    [ $# -ge 2 ] || fail "$1 needs a value; see --help"
    arguments+=("$1" "$2") && shift 2
    ;;
  *) break ;;
  esac
done
case ${1:-} in
--camera | --test-source)
  kind=${1#--}
  shift
  ;;
esac
read_arguments "$@"

case $kind in
test-source) input="test" ;;
camera) need_camera "${input:=/dev/video0}" ;;
file)
  [ -z "$input" ] || need_input "$input"
  ;;
esac
need_display

# Installs packages and builds.
set_up() {
  install_packages "${run_packages[@]}" "${build_packages[@]}" "${view_packages[@]}"
  if [ -f "$build/build.ninja" ] && [ ! -x "$program" ]; then # configured before the packages were installed
    meson setup --reconfigure "$build" >"$build/build.log" 2>&1 || build_failed "$build/build.log"
  fi
  build_plugins
}

program=$build/pipelines/feeling-wind/feeling-wind
if in_checkout && [ -z "${FEELING_WIND_BUILD:-}" ]; then
  # demo.sh builds the program and does not install its window.
  if [ -x "$program" ] && gst-inspect-1.0 --exists gtksink; then build_plugins; else set_up; fi
elif [ ! -x "$program" ]; then
  program=$(command -v feeling-wind) ||
    fail "feeling-wind is not in the build '$build'; as root run: apt-get install ${view_packages[*]}, then build again"
fi
use_elements hapticoverlay
[ ! -x "$build/pipelines/films/wind-film" ] || PATH=$build/pipelines/films:$PATH # for the film of the demonstration
[ "$kind" != file ] || [ -n "$input" ] || input=$(wind_film)

for option in "${sink_options[@]}"; do
  arguments+=(--sink "$option")
done
show_line "${program##*/}" "${arguments[@]}" "$input"
exec "$program" "${arguments[@]}" -- "$input"
