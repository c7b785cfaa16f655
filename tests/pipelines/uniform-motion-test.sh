#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A picture that moves uniformly gives the force of the paper's equation 5, in the direction of the
# motion (up in the picture is up for the hand), within 2 % of max-force once it has settled.

source "$(dirname "$0")/support.sh"

for velocity in 0,-20 0,-100 0,-400 100,0 60,80; do
  clip "$work/clip.mkv" 352 288 30 4 "uniform:$velocity"
  promise "a clip that moves at $velocity px/s plays to its end" \
    "$root/pipelines/play-file.sh" "$work/clip.mkv" -- device=sim "log-location=$work/log.csv"
  promise "its log is sound" sound_log "$work/log.csv" 1 4
  read -r fx fy < <(force_of "${velocity%,*}" "${velocity#*,}")
  promise "its force is equation 5 of the velocity" felt "$work/log.csv" "$fx" "$fy"
done

clip "$work/clip.mkv" 352 288 30 2 uniform:0,-100
promise "options after -- reach hapticsink" \
  "$root/pipelines/play-file.sh" "$work/clip.mkv" -- device=sim max-force=2 alpha=0.02 \
  "log-location=$work/log.csv"
read -r fx fy < <(force_of 0 -100 2 0.02)
promise "and change the force" felt "$work/log.csv" "$fx" "$fy" 2

# The same visible motion in a picture of another size: 100 px/s at a width of 352 px.
clip "$work/clip.mkv" 1280 720 30 3 uniform:0,-363.636
promise "a larger clip plays to its end" \
  "$root/pipelines/play-file.sh" "$work/clip.mkv" -- device=sim "log-location=$work/log.csv"
promise "the same visible motion is the same force" felt "$work/log.csv" 0 0.5
