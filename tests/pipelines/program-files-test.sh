#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The files that a desktop reads about feeling-wind, and what the program refuses.

source "$(dirname "$0")/support.sh"
data=$root/pipelines/feeling-wind/data

promise "the desktop file starts the program with one film" grep -qx 'Exec=feeling-wind %u' "$data/feeling-wind.desktop"
# shellcheck disable=SC2016 # $0 is awk's
promise "each of its lines is a group or KEY=VALUE" \
  awk '!/^\[Desktop Entry\]$/ && !/^[A-Za-z]+=.+$/ { print; bad = 1 } END { exit bad }' "$data/feeling-wind.desktop"
if [ -x "$build/pipelines/feeling-wind/feeling-wind" ]; then
  # `fails_with TEXT COMMAND...`: exit status 1 and that text.
  fails_with() {
    local text=$1 status=0
    shift
    "$@" >"$work/output" 2>&1 || status=$?
    cat "$work/output"
    [ "$status" = 1 ] && grep -q -- "$text" "$work/output"
  }
  program=$build/pipelines/feeling-wind/feeling-wind
  promise "without a display it says so" fails_with "there is no display for the window" \
    env -u DISPLAY -u WAYLAND_DISPLAY "$root/pipelines/view.sh" "$0"
  promise "nor does one help that does not answer" fails_with "there is no display for the window" \
    env -u WAYLAND_DISPLAY DISPLAY=:4321 "$root/pipelines/view.sh" --test-source
  promise "a missing file is named" fails_with "there is no file 'missing.mp4'" \
    env DISPLAY=:0 "$root/pipelines/view.sh" missing.mp4
  promise "the help needs no display" env -u DISPLAY -u WAYLAND_DISPLAY "$program" --help >/dev/null

  for option in max-force=0,2 max-force=50 max-force alpha=0,04 force-law=strong strength=1; do
    promise "a property that hapticsink does not accept is refused ($option)" \
      fails_with "$option.* is not a property of hapticsink" \
      env -u DISPLAY -u WAYLAND_DISPLAY "$program" --sink max-force=0.2 --sink "$option" test
  done
fi

command -v appstreamcli >/dev/null || skip "appstreamcli is not installed (package appstream)"
promise "the AppStream file is valid" appstreamcli validate --no-net "$data/org.feelingwind.FeelingWind.metainfo.xml"
