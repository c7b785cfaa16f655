#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# What a user has of the Debian packages that are installed here: tests/other-debian.sh and tests/container.sh install
# them and run this. Needs gstreamer1.0-tools and gstreamer1.0-plugins-good; with gstreamer1.0-plugins-base-apps it
# checks more.
set -euo pipefail
source "$(dirname "$0")/support/promise.sh"

unset GST_PLUGIN_PATH GST_PLUGIN_PATH_1_0 SPIDAR_GEOMETRY_PATH FEELING_WIND_WEB
export LC_ALL=C.UTF-8
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export HOME=$work GST_REGISTRY=$work/registry.bin

is_installed() {
  dpkg-query -W -f '${db:Status-Status}\n' "$1" 2>/dev/null | grep -qx installed
}
packages=(feeling-wind)
! is_installed feeling-wind-gtk || packages+=(feeling-wind-gtk)

elements_are_found() {
  local element
  for element in roitracker velocityavg hapticsink motionfield hapticconvert; do
    gst-inspect-1.0 "$element" | grep '^  Filename  *\(/usr\)\?/lib/' || return
  done
}
programs_explain_themselves() {
  local program
  dpkg -L "${packages[@]}" | grep '^/usr/bin/' >"$work/programs"
  while read -r program; do
    if ! "$program" --help >"$work/help" </dev/null || [ ! -s "$work/help" ]; then
      echo "$program"
      return 1
    fi
  done <"$work/programs"
}
# Two seconds that move to the left at 60 px/s.
film=(videotestsrc num-buffers=60 pattern=checkers-8 horizontal-speed=2
  ! "video/x-raw,width=352,height=288,framerate=30/1")
films_are_authored() {
  gst-launch-1.0 -q "${film[@]}" ! vp8enc keyframe-max-dist=30 ! webmmux ! filesink "location=$work/film.webm" &&
    haptic-track author "$work/film.webm" && haptic-track info "$work/film.haptic.mkv" | tee "$work/info" &&
    grep -q '^ *fields  *60$' "$work/info"
}
motion_becomes_a_force() {
  gst-launch-1.0 -q "${film[@]}" ! roitracker ! velocityavg \
    ! hapticsink device=sim sim-hand=hold:0.5,0,0 "log-location=$work/force.csv" &&
    awk -F, 'NR == 1 { while ($++x != "fx"); } $x < -0.1 { found = 1 } END { exit !found }' "$work/force.csv"
}
haptic_film_plays() {
  (cd "$work" && haptic-film play film.webm -- device=sim log-location=played.csv) && [ -s "$work/played.csv" ]
}
# shellcheck disable=SC2046 # several options
c_programs_use_the_library() {
  cc -o "$work/hold" /usr/share/doc/libspidar-dev/examples/hold.c $(pkg-config --cflags --libs spidar)
}

documentation_is_linked() {
  ! find /usr/share/doc/feeling-wind -name '*.md.gz' -o -name '*.webp.gz' | grep .
}

promise "GStreamer finds the elements" elements_are_found
promise "pages and pictures have the names that the pages link to" documentation_is_linked
promise "the service of the guardian waits until somebody enables it" \
  test ! -e /etc/systemd/user/sockets.target.wants/spidar-guardian.socket
promise "every program says how to use it" programs_explain_themselves
promise "a film is authored" films_are_authored
! command -v gst-discoverer-1.0 >/dev/null || promise "haptic-film plays a film" haptic_film_plays
promise "motion becomes a force on a simulated device" motion_becomes_a_force
! is_installed libspidar-dev || promise "a program in C uses the library" c_programs_use_the_library
