#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Every key, button and menu item of feeling-wind under X with a window manager, and under Wayland (weston).
#
# Set SCREENSHOTS to a folder to keep what was on the screen.

# Inside the X server: `program-controls-test.sh SYSTEM PROGRAM VIDEO FOLDER`.
if [ $# = 4 ]; then
  set -euo pipefail
  tests=$(dirname "$(readlink -f "$0")") system=$1
  cd "$4"
  export SCREEN_SIZE=1024x768
  if [ "$system" = wayland ]; then
    export XDG_RUNTIME_DIR=$PWD
    printf '[core]\nidle-time=0\n[shell]\nanimation=none\nstartup-animation=none\nclose-animation=none\n' >weston.ini
    printf 'panel-position=none\nbackground-color=0xffff00ff\n' >>weston.ini
    weston --backend=x11-backend.so --use-pixman --width=1024 --height=768 --config="$PWD/weston.ini" \
      --socket=wayland-test >weston.log 2>&1 &
    for _ in {1..300}; do
      [ ! -S wayland-test ] || break
      sleep 0.1
    done
    export WAYLAND_DISPLAY=wayland-test GDK_BACKEND=wayland
  else
    openbox >openbox.log 2>&1 &
    export GDK_BACKEND=x11
  fi
  manager=$!
  trap 'kill "$manager" 2>/dev/null || true' EXIT
  "$tests/use-every-control.py" "$2" "$3"
  exit
fi

source "$(dirname "$0")/support.sh"
program=$build/pipelines/feeling-wind/feeling-wind
[ -x "$program" ] || skip "feeling-wind is not built (package libgtk-3-dev)"
need_window_system
for needed in xdotool openbox weston dbus-run-session; do
  command -v "$needed" >/dev/null || skip "$needed is not installed"
done
gst-inspect-1.0 --exists gtksink || skip "gtksink is not installed (package gstreamer1.0-gtk3)"
/usr/bin/python3 -c 'import gi, numpy
gi.require_version("Atspi", "2.0")' 2>/dev/null || skip "Python has no Atspi or numpy (packages gir1.2-atspi-2.0, python3-numpy)"
export GSETTINGS_BACKEND=memory
unset WAYLAND_DISPLAY

clip "$work/clip.mkv" 352 288 30 20 halves:0,-100,0,100
mkdir "$work/bin"
printf '#!/bin/sh\nexec sleep 120\n' >"$work/bin/wind-film" # as long as it draws
chmod +x "$work/bin/wind-film"
export PATH=$work/bin:$PATH

# `in_system SYSTEM`: X or Wayland, with settings of its own.
in_system() {
  local status=0 folder=$work/$1
  mkdir -m 700 "$folder"
  XDG_CONFIG_HOME=$folder/config XDG_CACHE_HOME=$folder/cache \
    in_window_system dbus-run-session -- "$0" "$1" "$program" "$work/clip.mkv" "$folder" || status=$?
  [ -z "${SCREENSHOTS:-}" ] || { mkdir -p "$SCREENSHOTS/$1" && cp "$folder"/*.png "$SCREENSHOTS/$1"; }
  return "$status"
}
promise "every key, button and menu item works under X" in_system x11
promise "and under Wayland" in_system wayland
