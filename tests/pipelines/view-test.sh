#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck disable=SC2317 # until_true calls its functions by name
# The window of view.sh under real keys and a real mouse, looked at on the screen.

# `color SHOT NAME`: how many pixels of 200x200 have this colour, and their mean row.
color() {
  od -An -v -tu1 -w3 "$1" | awk -v "name=$2" '
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
  # `until_true COMMAND...` repeats a command until it succeeds. The limit is meant for a machine with other work.
  until_true() {
    for _ in {1..300}; do
      ! "$@" || return 0
      sleep 0.1
    done
    echo "this did not happen within 30 s: $*" >&2
    exit 1
  }
  # `press KEY WORDS` waits until the program has written what that did.
  press() {
    local before
    before=$(grep -c -- "$2" said) || true
    xdotool key "$1"
    written() { [ "$(grep -c -- "$2" said)" -gt "$before" ]; }
    until_true written "$@"
  }
  # `shot_until NAME COLOR CONDITION [LEFT TOP]`: a shot that fulfils the condition on n and row; of the video
  # by default.
  shot_until() {
    fulfilled() {
      shot "$1" "${4:-147}" "${5:-150}"
      shows "$1" "$2" "$3" >/dev/null
    }
    until_true fulfilled "$@"
  }
  # `differs NAME OTHER LEFT TOP`: a new shot NAME is not like OTHER.
  differs() {
    shot "$1" "$3" "$4"
    ! cmp -s "$1" "$2"
  }
  # `stands NAME LEFT TOP`: a shot NAME, and half a second later another one that is like it.
  stands() {
    shot "$1" "$2" "$3"
    sleep 0.5
    shot "$1-later" "$2" "$3"
    cmp -s "$1" "$1-later"
  }

  window=$(timeout 60 xdotool search --sync --onlyvisible --pid "$process" | tail -n 1)
  until_true grep -q 'first frame' said
  xdotool windowfocus "$window"
  # The video, 611x500 px, is in the middle of the 800 above the strip; this is the middle of its left half.
  xdotool mousemove 240 250
  xdotool mousemove 247 250
  # What moves up has an arrow up, and a force up.
  shot_until forward orange 'n > 100 && row < 95'
  shot_until forward blue 'n > 50 && row < 95'
  shot_until strip orange 'n > 100' 600 500
  until_true differs strip-later strip 600 500
  press space paused
  until_true stands paused 147 150
  until_true stands strip-paused 600 500
  press space playing
  press s 'force off'
  shot_until off blue 'n == 0'
  press s 'force on'
  press r 'at -1 times'
  shot_until backward orange 'n > 100 && row > 105'
  shot_until backward blue 'n > 50 && row > 105'
  press minus 'at -0.5 times'
  press plus 'at -1 times'
  press bracketright 'region of 38 px'
  press greater 'strength (alpha) 0.015 s/px'
  press less 'strength (alpha) 0.01 s/px'
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
promise "a file without pictures is refused" fails_with "is not a video: it holds sound only" \
  in_window_system timeout 20 "$root/pipelines/view.sh" "$work/sound.wav"
promise "by one sentence" test "$(grep -c '^view.sh: ' "$work/output")" = 1
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

clip "$work/clip.mkv" 352 288 30 20 halves:0,-100,0,100
promise "keys and mouse steer it: arrows and forces follow, the strip scrolls but not while paused, and q ends it well" \
  in_window_system "$0" steer "$root/pipelines/view.sh" "$work/clip.mkv" "$work"
cat "$work/said"
cd "$work"
promise "the strip has both curves" shows strip orange 'n > 100'
