#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# How often a hand tells the motion that velocityavg measures live from the exact one, for each way to average: the mean
# of 15 places of a film of 5 s. The exact one is the mean of roitracker's square, or of what moves in it with the pixel
# under the pointer. Takes two minutes a seed.
#
# Usage: tests/measure/felt/pointed.sh [SEED]...
#   SEED  of wind-film (4711)
#
# Takes the programs from build/.

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

case ${1:-} in
--help | -h) show_help && exit ;;
-*) fail "unknown option '$1'; see --help" ;;
esac
[ $# -gt 0 ] || set -- 4711
source "$(dirname "$0")/film-and-places.sh"

echo "seed  average  truth    alpha (s/px)  told apart"
for seed in "$@"; do
  for of in square pointed; do
    "$program" --seed "$seed" --width 1920 --height 1080 --rate 30 --duration 5 --truth "$work/$seed-$of" --truth-of $of \
      --places "$places" "$work/$seed.mkv"
  done
  for average in model pointed mean; do
    for place in $places; do
      mkdir -p "$work/$average"
      gst-launch-1.0 -q filesrc location="$work/$seed.mkv" ! matroskademux name=demux demux.video_0 ! avdec_h264 ! roitracker \
        pointer-x="${place%,*}" pointer-y="${place#*,}" ! velocityavg average=$average ! hapticconvert ! meta/x-klv,parsed=true ! \
        filesink location="$work/$average/${place/,/-}.klv"
    done
    for of in square pointed; do
      for alpha in 0.01 0.04; do
        for live in "$work/$average"/*.klv; do
          haptic_track compare --json --alpha $alpha "$work/$seed-$of/$(basename "$live" .klv).txt" "$live"
        done | awk -v seed="$seed" -v average=$average -v of=$of -v alpha=$alpha -F '[:,]' '
          { sum += $2 }
          END { printf "%-5d %-8s %-8s %-13s %4.1f %%\n", seed, average, of, alpha, 100 * sum / NR }'
      done
    done
  done
done
