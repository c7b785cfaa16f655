#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A C program of 40 lines that pushes a hand on with 5 N meets the limits of hapticsink, and can say
# what stopped it.
# Usage: push-test.sh PROGRAM SOURCE
set -euo pipefail
program=$1

[ "$(wc -l <"$2")" -le 40 ] || { echo "FAILED: $2 has more than 40 lines" && exit 1; }

# `push HAND WORK REASON`: at most 5 N, 1000 N/s and WORK J, and what holds the force in the end.
push() {
  local force change work reason
  read -r force _ change _ work _ reason < <("$program" "$1")
  echo "$1: $force N, $change N/s, $work J. $reason"
  awk -v f="$force" -v c="$change" -v w="$work" -v most="$2" \
    'BEGIN { exit !(f > 2 && f <= 5 && c <= 1000 && w > most / 10 && w <= most) }' ||
    { echo "FAILED: not within 5 N, 1000 N/s and $2 J" && exit 1; }
  grep -qxE -- "$3" <<<"$reason" || { echo "FAILED: the reason is '$reason'" && exit 1; }
}

# A hand that is led round at 0.7 m/s: 0.9 J and 0.3 W, 2.4 J in 5 s (docs/force.md#after-the-law).
push circle:0.8,0.2 2.4 ''
# One at 1 m/s has let go of the grip.
push circle:0.8,0.1257 0.9 '.*as if it had been let go.*spidar_arm\(\)\.'
