#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# In the virtual machine: a film is felt on a joystick with force feedback that the kernel believes in.

source "$(dirname "$0")/vm-support.sh"
use_elements hapticsink

modprobe uinput
modprobe evdev
promise "the joystick's own tests hold" env GTEST_BRIEF=1 "$build/tests/unit/unit-evdev-device"

mkfifo "$work/stick"
"$build/tests/hil/virtual-joystick" <"$work/stick" >"$work/told" &
joystick=$!
exec 4>"$work/stick"
promise "the kernel has a joystick" within 20 grep -q ^/dev/input/event "$work/told"

listed() {
  gst-device-monitor-1.0 Sink/Haptics | tee "$work/devices" | grep "device = evdev:$(head -n 1 "$work/told")" >/dev/null ||
    { cat "$work/devices"; return 1; }
}
promise "gst-device-monitor-1.0 lists it" listed

# The stick is pushed to the right, where the picture moves to the right.
echo 0.5 0 0 >&4
promise "the pipeline runs" timeout -k 5 60 gst-launch-1.0 -q --no-position -e \
  videotestsrc is-live=true num-buffers=90 pattern=checkers-8 horizontal-speed=-4 \
  ! video/x-raw,width=352,height=288,framerate=30/1 \
  ! roitracker ! velocityavg ! hapticsink device=evdev "log-location=$work/ticks.csv"

# Of the effects that can be felt well, all point to the right (0xC000 or nearly).
felt() {
  sleep 0.2
  awk '
    /^upload/ && $3 > 1500 { strong++; if ($5 < 48000 || $5 > 50300 || $7 != 100) wrong++ }
    END { print strong + 0 " strong effects, " wrong + 0 " wrong"; exit !(strong > 0 && wrong == 0) }' "$work/told"
}
pointed() {
  awk -F, 'NR > 300 { rows++; if ($2 > 0.019 && $2 < 0.021) right++ }
    END { exit !(rows > 100 && right == rows) }' "$work/ticks.csv"
}
promise "its stick was the pointer" pointed
promise "the force was played in its direction" felt
promise "and erased at the end" grep -qx erase "$work/told"

# `held_with PRESSED`: how many frames roitracker says are held while the button is so from the first
# frame on.
held_with() {
  timeout -k 5 60 gst-launch-1.0 -m --no-position videotestsrc is-live=true num-buffers=90 pattern=checkers-8 \
    ! video/x-raw,width=352,height=288,framerate=30/1 \
    ! roitracker ! velocityavg post-messages=true ! hapticsink device=evdev >"$work/messages" &
  within 30 grep -q haptic-motion "$work/messages"
  echo 0.5 0 "$1" >&4
  wait $!
  grep -c 'haptic-motion.* held=' "$work/messages" || true
}
promise "its button arrives at the tracker as a press" test "$(held_with 1)" -gt 20
promise "a button that was pressed before the start does not" test "$(held_with 1)" = 0
promise "nor one that is released" test "$(held_with 0)" = 0
exec 4>&-
wait "$joystick"
