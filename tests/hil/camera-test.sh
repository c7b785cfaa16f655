#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# In the virtual machine: cameras of every kind are felt on a SPIDAR-G, and whatever a camera does, no force stays.
# The driver vivid draws the pictures and fails when it is told to.

source "$(dirname "$0")/vm-support.sh"
[ -e "$build/gst-plugins/vision/libgsthapticvision.so" ] || skip "the vision plugin is not built"
command -v v4l2-ctl >/dev/null || skip "v4l2-ctl is not installed (v4l-utils)"
use_elements

# The nodes of cameras, each of a driver's instance: a fault of one leaves the others alone.
# A camera on HDMI is left out: 60 frames a second are too many for emulated processors. When its timings change or its
# signal ends, v4l2src does the same before hapticsink as before a fakesink.
webcam=0 tv=1 planar=2
modprobe vivid n_devs=3 node_types=1,1,1 num_inputs=1,1,1 input_types=0,1,0 multiplanar=1,1,2 vid_cap_nr=0,1,2
promise "the kernel has three cameras" within 20 test -c /dev/video2

# Black and white squares of 16 px (pattern 10) move 2 px a frame to the right (movement 4), with no text over them (2).
for camera in $webcam $tv $planar; do
  v4l2-ctl -d "$camera" -c test_pattern=10,osd_text_mode=2,horizontal_movement=4 ||
    fail "the camera $camera takes no controls"
done

small=video/x-raw,width=320,height=180,framerate=15/1
# Emulated processors lose frames: the squares must not move by one of them meanwhile.
slow=video/x-raw,width=320,height=180,framerate=5/1

# `motion_of CAMERA CAPS PROPERTY...`: most frames move to the right.
motion_of() {
  local status=0
  timeout -k 5 120 gst-launch-1.0 -m --no-position v4l2src "device=/dev/video$1" num-buffers=10 "${@:3}" ! "$2" \
    ! roitracker roi-size=60 ! velocityavg post-messages=true ! hapticsink device=sim >"$work/said" 2>&1 || status=$?
  sed -n 's/.*haptic-motion.* vx=(double)\([^,]*\), vy=(double)\([^,]*\),.*/\1 \2/p' "$work/said" |
    awk '$1 > 5 && $2 < $1 / 2 && $2 > -$1 / 2 { right++ }
      END { print NR " motions, " right + 0 " to the right"; exit !(right > 3 && right > NR / 2) }' || status=1
  [ $status = 0 ] || tail "$work/said"
  return $status
}

for format in YUY2 NV12 NV16 GRAY8 GRAY16_LE BGRx; do
  promise "frames in $format are felt" motion_of $webcam "$slow,format=$format"
done
for mode in rw dmabuf; do
  promise "frames that come by io-mode=$mode are felt" motion_of $webcam "$slow,format=YUY2" io-mode=$mode
done
is_called() {
  v4l2-ctl -d $planar --get-fmt-video | grep -F "'$1'"
}
for format in I420:YM12 NV12:NM12; do
  promise "frames in ${format%:*} whose planes are apart are felt" motion_of $planar "$slow,format=${format%:*}"
  promise "which the driver calls ${format#*:}" is_called "${format#*:}"
done

start_emulator --controller simple
promise "the kernel sees a USB2.0 Simple" attach 1 0203
measure_the_bus

# `start CAMERA CAPS`: what it shows is felt on the unit, in the background. It has a minute to stop after Ctrl-C:
# `timeout` kills it so long after any signal that it passes on, and emulated processors need seconds. In the foreground it
# passes a signal on once: the second of two would kill a process that stops already.
start() {
  line=0
  stdbuf -oL timeout --foreground -k 60 300 gst-launch-1.0 -m --no-position v4l2src "device=/dev/video$1" ! "$2" \
    ! roitracker roi-size=60 ! velocityavg post-messages=true ! hapticsink device=usb:0 >"$work/said" 2>&1 &
  pipeline=$!
}
# The camera's motion comes since the last call of `from_now`.
moves() {
  tail -n "+$((line + 1))" "$work/said" | grep -a 'haptic-motion.* confidence=(double)1'
}
from_now() {
  line=$(wc -l <"$work/said")
}
runs() {
  kill -0 "$pipeline"
}
moves_or_ends() {
  moves || ! runs
}
# The noise of a camera without a signal comes, too, without a motion.
sees_or_ends() {
  tail -n "+$((line + 1))" "$work/said" | grep -a haptic-motion || ! runs
}
# Each motor is at minimum tension, and stays there.
rests() {
  within 20 told "rows > 0 && largest <= least" && sleep 0.5 && told "largest <= least"
}
# It has ended by itself: not by a signal, and with an error.
failed() {
  local status=0
  ! runs 2>/dev/null || { tail -n 3 "$work/said"; return 1; }
  wait "$pipeline" || status=$?
  grep -a -A 2 '^ERROR' "$work/said" || status=none
  [ $status = 1 ] || { echo "exit status $status"; tail -n 20 "$work/said"; return 1; }
}
# Ctrl-C ends it without an error.
stops() {
  local status=0
  kill -INT "$pipeline"
  wait "$pipeline" || status=$?
  [ $status = 0 ] || { echo "exit status $status"; tail -n 20 "$work/said"; return 1; }
}
# Where it cannot go on, it says so.
stops_or_failed() {
  if runs 2>/dev/null; then stops; else failed; fi
}
ends() {
  within 120 eval '! runs' && failed
}

start $webcam "$small"
promise "a webcam moves" within 120 moves
# A tick more than 10 ms late holds the force, as it should.
[ "$exchange_time" -gt 15000 ] || promise "and its force is told to the motors" within 20 told "largest > least"
for _ in 1 2 3; do
  v4l2-ctl -d $webcam -c inject_v4l2_buf_flag_error=1
  sleep 0.3
done
from_now
promise "frames that the driver calls damaged do not end it" within 30 moves
v4l2-ctl -d $webcam -c percentage_of_dropped_buffers=100
promise "while no frame comes, there is no force" rests
from_now
v4l2-ctl -d $webcam -c percentage_of_dropped_buffers=0
promise "and the motion comes back with the frames" within 120 moves
v4l2-ctl -d $webcam -c inject_vidioc_qbuf_error=1
from_now
promise "a buffer that the driver does not take ends it, or it goes on" within 120 moves_or_ends
promise "it ends when it is told to" stops_or_failed
promise "without a force" rests

for fault in reqbufs streamon; do
  v4l2-ctl -d $webcam -c inject_vidioc_${fault}_error=1
  start $webcam "$small"
  promise "a start without $fault ends it, or it goes on" within 120 moves_or_ends
  promise "and it ends" stops_or_failed
  promise "without a force" rests
done

start $webcam "$small"
promise "the webcam moves again" within 120 moves
v4l2-ctl -d $webcam -c inject_fatal_streaming_error=1
promise "a fatal error of the driver ends it" ends
promise "without a force" rests

# `changes CAMERA CAPS CONTROLS`: the source changes while it streams.
changes() {
  start "$1" "$2"
  within 120 moves && v4l2-ctl -d "$1" -c "$3" && sleep 2 && from_now && within 120 sees_or_ends &&
    stops_or_failed && rests
}
tv_caps=video/x-raw,format=I420
promise "another standard on television (PAL): it goes on, or says why not" \
  changes $tv $tv_caps standard_signal_mode=4,standard=3
promise "no signal on television: it goes on, or says why not" changes $tv $tv_caps standard_signal_mode=1

start $webcam "$small"
promise "the webcam moves once more" within 120 moves
v4l2-ctl -d $webcam -c disconnect=1
promise "a webcam that is unplugged ends it" ends
promise "without a force" rests
