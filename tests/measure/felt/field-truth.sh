#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# How often a hand tells the exact motion of wind-film from the film's own track, whose fields are coded: the mean of 15
# places of two films of 5 s, and the bitrate of the track. Takes a minute.
#
# Usage: tests/measure/felt/field-truth.sh [RATE]
#   RATE  frames a second (60)
#
# Takes the programs from build/.

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

case ${1:-} in
--help | -h) show_help && exit ;;
-*) fail "unknown option '$1'; see --help" ;;
esac
rate=${1:-60}
source "$(dirname "$0")/film-and-places.sh"

echo "seed  alpha (s/px)  told apart  track (kbit/s)"
for seed in 4711 90210; do
  video=$work/$seed.mkv
  # The quality of the pictures does not matter here.
  "$program" --quality 40 --seed $seed --rate "$rate" --duration 5 --truth "$work/$seed" --places "$places" "$video"
  haptic_track convert "$video" "$work/$seed.klv" >/dev/null
  for alpha in 0.01 0.04; do
    for truth in "$work/$seed"/*.txt; do
      # Both begin with the first frame: what the code delays counts.
      haptic_track compare --json --shift 0 --alpha $alpha "$truth" "$work/$seed.klv"
    done | awk -v seed=$seed -v alpha=$alpha -v bytes="$(stat -c %s "$work/$seed.klv")" -F '[:,]' '
      { sum += $2 }
      END { printf "%-5d %-13s %4.1f %%      %.0f\n", seed, alpha, 100 * sum / NR, bytes * 8e-3 / 5 }'
  done
done
