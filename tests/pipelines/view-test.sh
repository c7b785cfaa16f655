#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The window of view.sh under real keys and a real mouse, looked at on the screen.

# Runs inside the window system: `view-test.sh steer SCRIPT VIDEO FOLDER` leaves what the program said and
# what was on the screen in FOLDER.
if [ "${1:-}" = steer ]; then
  set -euo pipefail
  cd "$4"
  "$2" --verbose "$3" >said 2>&1 &
  process=$!
  trap 'kill $process 2>/dev/null || true' EXIT

  # What is on the screen, 24 bits a pixel: `shot NAME LEFT TOP`, 200x200 px.
  shot() {
    gst-launch-1.0 -q ximagesrc num-buffers=1 use-damage=false show-pointer=false \
      "startx=$2" "starty=$3" "endx=$(($2 + 199))" "endy=$(($3 + 199))" \
      ! videoconvert ! video/x-raw,format=RGB ! filesink "location=$1"
  }
  # `press KEY WORDS` waits until the program has said what that did.
  press() {
    xdotool key "$1"
    for _ in {1..50}; do
      ! grep -q -- "$2" said || return 0
      sleep 0.1
    done
    echo "the key $1 did nothing" >&2
    exit 1
  }

  window=$(timeout 30 xdotool search --sync --onlyvisible --pid "$process" | tail -n 1)
  for _ in {1..100}; do
    ! grep -q 'first frame' said || break
    sleep 0.1
  done
  xdotool windowfocus "$window"
  # The video, 611x500 px, is in the middle of the 800 above the strip; this is the middle of its left half.
  xdotool mousemove 240 250
  xdotool mousemove 247 250
  sleep 1.2
  shot forward 147 150
  shot strip 600 500
  sleep 0.5
  shot strip-later 600 500
  press space paused
  sleep 0.3
  shot paused 147 150
  shot strip-paused 600 500
  sleep 0.5
  shot paused-later 147 150
  shot strip-paused-later 600 500
  press space playing
  press s 'force off'
  sleep 0.5
  shot off 147 150
  press s 'force on'
  press r 'at -1 times'
  sleep 1.2
  shot backward 147 150
  press minus 'at -0.5 times'
  press plus 'at -1 times'
  press bracketright 'region of 38 px'
  press l 'force law arctan-axis'
  xdotool key q
  wait "$process"
  exit
fi

source "$(dirname "$0")/support.sh"
[ -x "$build/pipelines/view/feeling-wind-view" ] || skip "feeling-wind-view is not built (package libgtk-3-dev)"
export NO_AT_BRIDGE=1 # nobody has started an accessibility bus

# `fails_with TEXT COMMAND...`: exit status 1 and that text.
fails_with() {
  local text=$1 status=0
  shift
  "$@" >"$work/output" 2>&1 || status=$?
  cat "$work/output"
  [ "$status" = 1 ] && grep -q -- "$text" "$work/output"
}
promise "without a display it says so" fails_with "there is no display for the window" \
  env -u DISPLAY -u WAYLAND_DISPLAY "$root/pipelines/view.sh" "$0"
promise "nor does one help that does not answer" fails_with "there is no display for the window" \
  env -u WAYLAND_DISPLAY DISPLAY=:4321 "$root/pipelines/view.sh" --test-source
promise "a missing file is named" fails_with "there is no file 'missing.mp4'" \
  env DISPLAY=:0 "$root/pipelines/view.sh" missing.mp4

need_window_system
command -v xdotool >/dev/null || skip "xdotool is not installed"
gst-inspect-1.0 --exists gtksink || skip "gtksink is not installed (package gstreamer1.0-gtk3)"

gst-launch-1.0 -q audiotestsrc num-buffers=20 ! wavenc ! filesink "location=$work/sound.wav"
promise "a file without pictures is refused" fails_with "no frame can be shown.*Is it a video" \
  in_window_system timeout 20 "$root/pipelines/view.sh" "$work/sound.wav"
promise "by one sentence" test "$(grep -c '^feeling-wind-view: ' "$work/output")" = 1
promise "so is a video of no pictures" fails_with "the video holds no frames" \
  in_window_system timeout 20 "$build/pipelines/view/feeling-wind-view" videotestsrc num-buffers=0 ! roitracker \
  ! tee name=t t. ! queue ! videoconvert ! hapticoverlay ! gtksink t. ! queue ! velocityavg ! hapticsink device=sim
promise "so is a joystick that is none" fails_with "is no input device" \
  in_window_system timeout 20 "$root/pipelines/view.sh" --test-source -- device=evdev:/dev/null
promise "100 wide pictures a second are shown until Ctrl-C" \
  in_window_system timeout --foreground --preserve-status -k 10 -s INT 2.5 \
  "$build/pipelines/view/feeling-wind-view" --verbose videotestsrc is-live=true ! \
  video/x-raw,width=320,height=240,framerate=100/1,pixel-aspect-ratio=4/3 ! \
  queue leaky=downstream max-size-buffers=1 ! roitracker ! tee name=t \
  t. ! queue max-size-buffers=1 ! videoconvert ! hapticoverlay ! gtksink \
  t. ! queue max-size-buffers=1 ! velocityavg post-messages=true ! hapticsink device=sim

clip "$work/clip.mkv" 352 288 30 4 halves:0,-100,0,100
promise "keys and mouse steer it, and q ends it well" \
  in_window_system "$0" steer "$root/pipelines/view.sh" "$work/clip.mkv" "$work"
cat "$work/said"
# shellcheck disable=SC2016 # $4 is awk's
promise "the first picture comes within a second" \
  awk '/^first picture after/ { soon = $4 <= 1 } END { exit !soon }' "$work/said"

# `color SHOT NAME`: how many pixels of 200x200 have this colour, and their mean row.
color() {
  od -An -v -tu1 -w3 "$work/$1" | awk -v "name=$2" '
    function is() {
      return name == "orange" ? $1 > $2 + 50 && $2 > $3 + 50 : $3 > $2 + 30 && $2 > $1 + 30
    }
    is() { n++; rows += int((NR - 1) / 200) }
    END { printf "%d %d\n", n, n ? rows / n : -1 }'
}
# `shows SHOT NAME CONDITION` on n and row.
shows() {
  local n row
  read -r n row < <(color "$1" "$2")
  echo "$1: $n $2 pixels about row $row"
  [ "$n" -ge 0 ] && (($3))
}
promise "what moves up has an arrow up" shows forward orange 'n > 100 && row < 95'
promise "and a force up" shows forward blue 'n > 50 && row < 95'
promise "s takes the force away" shows off blue 'n == 0'
promise "played backwards it moves down" shows backward orange 'n > 100 && row > 105'
promise "and the force with it" shows backward blue 'n > 50 && row > 105'
promise "the strip has both curves" shows strip orange 'n > 100'
differ() { ! cmp -s "$work/$1" "$work/$2"; }
promise "the strip scrolls" differ strip strip-later
promise "not while paused" cmp "$work/strip-paused" "$work/strip-paused-later"
promise "nor does the video" cmp "$work/paused" "$work/paused-later"
