# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2154,SC2317 # $program is set by the tests that source it; functions called by name
# What the tests of feeling-wind share that use its window with xdotool. To be sourced inside the X server, in a
# scratch folder, with $program set.

# What is on the screen, 24 bits a pixel: `shot NAME LEFT TOP`, 200x200 px.
shot() {
  gst-launch-1.0 -q ximagesrc num-buffers=1 use-damage=false show-pointer=false \
    "startx=$2" "starty=$3" "endx=$(($2 + 199))" "endy=$(($3 + 199))" \
    ! videoconvert ! video/x-raw,format=RGB ! filesink "location=$1"
}
# `until_true COMMAND...` repeats a command until it succeeds. Only the end of the program ends that in vain.
until_true() {
  until "$@"; do
    if [ -n "${process:-}" ] && ! kill -0 "$process" 2>/dev/null && ! "$@"; then
      echo "the program ended before this happened: $*" >&2
      exit 1
    fi
    sleep 0.1
  done
}
# `start ARGUMENT...` runs the program and gives its window the keys.
start() {
  : >said # what the program before said is not what this one says
  "$program" --verbose "$@" >said 2>&1 &
  process=$!
  trap 'kill -CONT $process ${server:-} 2>/dev/null || true; kill $process ${server:-} 2>/dev/null || true' EXIT
  windows=$(timeout 120 xdotool search --sync --onlyvisible --class feeling-wind)
  window=$(tail -n 1 <<<"$windows")
  xdotool windowfocus "$window"
}
# `press KEY WORDS` waits until the program has written what that did.
press() {
  local before
  before=$(grep -c -- "$2" said) || true
  # shellcheck disable=SC2086 # several keys
  xdotool key $1
  written() { [ "$(grep -c -- "$2" said)" -gt "$before" ]; }
  until_true written "$@"
}
# Waits for another window of the program and gives it the keys.
dialog() {
  other_window() {
    other=$(xdotool search --onlyvisible --class feeling-wind | grep -vx "$windows" | tail -n 1)
    [ -n "$other" ]
  }
  until_true other_window
  xdotool windowfocus "$other"
}
# The program ends, with status 0.
ended() {
  gone() { ! kill -0 "$process" 2>/dev/null; }
  until_true gone
  local status=0
  wait "$process" || status=$?
  process=
  return $status
}
# `open_url URL` in the dialog for it.
open_url() {
  xdotool windowfocus "$window" key ctrl+l
  dialog
  xdotool type "$1"
  xdotool key Return
  xdotool windowfocus "$window"
}

# So many pipelines have shown a frame.
opened() {
  [ "$(grep -c 'first frame' said)" = "$1" ]
}
