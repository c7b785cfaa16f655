#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A film that is played slower, as it is, and faster is measured as its motion is seen. (The force of a motion:
# tests/elements/uniform-motion-test.cpp.)

source "$(dirname "$0")/support.sh"

clip "$work/clip.mkv" 352 288 30 1 uniform:80,0
# 5 % of these velocities are less than 2 % of the largest force.
for speed in 0.5 1 2; do
  promise "the clip plays at $speed times its speed" samples_of playback-speed.sh --speed "$speed" "$work/clip.mkv"
  promise "with the motion as it is seen" measured \
    "(vx - 80 * $speed) ^ 2 + vy ^ 2 < (0.05 * 80 * $speed) ^ 2"
done
# As DirectShow and VirtualDub write 30 frames a second.
"$MAKE_CLIP" 352 288 30 1 uniform:80,0 | gst-launch-1.0 -q fdsrc ! rawvideoparse format=gray8 width=352 height=288 \
  framerate=10000000/333333 ! videoconvert ! jpegenc quality=95 ! matroskamux ! filesink "location=$work/fraction.mkv"
promise "a film with large numbers in its frame rate plays" samples_of playback-speed.sh --speed 1 "$work/fraction.mkv"
promise "with its motion" measured "(vx - 80) ^ 2 + vy ^ 2 < (0.05 * 80) ^ 2"
promise "a speed that is none is an error" test "$(
  "$root/pipelines/playback-speed.sh" --speed fast "$work/clip.mkv" 2>&1 | grep -c 'a number from 0.01'
)" = 1
