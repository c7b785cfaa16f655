#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A picture that moves uniformly gives the force of the paper's equation 5, in the direction of the
# motion (up in the picture is up for the hand), within 2 % of max-force once it has settled.

source "$(dirname "$0")/support.sh"

# `settled_force FILE VX VY`: every row from 1.5 s to 3.5 s holds equation 5 of this velocity.
settled_force() {
  # shellcheck disable=SC2016
  in_log "$1" 'time < 1.5 || time > 3.5 ||
    (abs(fx - 2 / pi * atan(0.01 * speed) * ux / speed) <= 0.02 &&
     abs(fy + 2 / pi * atan(0.01 * speed) * uy / speed) <= 0.02)' \
    pi=3.141592653589793 "ux=$2" "uy=$3" "speed=$(awk "BEGIN { print sqrt($2 ^ 2 + $3 ^ 2) }")"
}

for velocity in 0,-20 0,-100 0,-400 100,0 60,80; do
  clip "$work/clip.mkv" 352 288 30 4 "uniform:$velocity"
  promise "a clip that moves at $velocity px/s plays to its end" \
    "$root/pipelines/play-file.sh" "$work/clip.mkv" -- device=sim "log-location=$work/log.csv"
  promise "its log is sound" sound_log "$work/log.csv" 1 4
  promise "its force is equation 5 of the velocity" settled_force "$work/log.csv" "${velocity%,*}" "${velocity#*,}"
done

clip "$work/clip.mkv" 352 288 30 2 uniform:0,-100
promise "options after -- reach hapticsink" \
  "$root/pipelines/play-file.sh" "$work/clip.mkv" -- device=sim max-force=2 alpha=0.02 \
  "log-location=$work/log.csv"
promise "and change the force" in_log "$work/log.csv" \
  'time < 1.2 || time > 1.8 || abs(fy - 4 / pi * atan(2)) < 0.04' pi=3.141592653589793

# The same visible motion in a picture of another size: 100 px/s at a width of 352 px.
clip "$work/clip.mkv" 1280 720 30 3 uniform:0,-363.636
promise "a larger clip plays to its end" \
  "$root/pipelines/play-file.sh" "$work/clip.mkv" -- device=sim "log-location=$work/log.csv"
promise "the same visible motion is the same force within 2 %" in_log "$work/log.csv" \
  'time < 1.2 || time > 2.5 || abs(fy - 0.5) <= 0.01'
