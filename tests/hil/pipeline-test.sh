#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# In the virtual machine: a camera's pictures are felt on a SPIDAR-G on USB.

source "$(dirname "$0")/vm-support.sh"
[ -e "$build/gst-plugins/vision/libgsthapticvision.so" ] || skip "the vision plugin is not built"
use_elements

start_emulator --controller simple
promise "the kernel sees a USB2.0 Simple" attach 1 0203
modprobe vivid n_devs=1 vid_cap_types=1
promise "the kernel has a camera" within 20 test -c /dev/video0
measure_the_bus
# A tick more than 10 ms late holds the force, as it should.
[ "$exchange_time" -le 15000 ] || skip "an exchange takes $exchange_time µs here, and a force needs 15000"

# Coloured squares move to the right by 4 px a picture: 120 px/s. The driver calls that movement 6, the
# squares pattern 4, and no text over them text mode 2.
promise "the pipeline runs" timeout -k 5 40 gst-launch-1.0 -q --no-position -e \
  v4l2src device=/dev/video0 num-buffers=150 \
  extra-controls=c,test_pattern=4,osd_text_mode=2,horizontal_movement=6 \
  ! video/x-raw,width=320,height=180,framerate=30/1 \
  ! roitracker roi-size=60 ! velocityavg ! hapticsink device=usb:0 "log-location=$work/ticks.csv"

felt() {
  awk -F, '
    NR == 1 { next }
    { rows++; if ($8 > 0.1) right++; if ($8 < -0.1) left++ }
    END { print rows " ticks, force to the right in " right + 0 ", to the left in " left + 0
          exit !(rows > 100 && right > rows / 10 && left < right / 10) }' "$work/ticks.csv"
}
promise "the motion is felt in its direction" felt
promise "and was told to the motors, which are left at minimum tension" \
  told "rows > 100 && largest <= least"
