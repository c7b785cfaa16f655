#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs a command and interrupts it, as Ctrl-C in a terminal does, once so many rows of hapticsink's log fulfil an awk
# condition on time (s of the stream), fx, fy and fz (N).
#
# Usage: tests/pipelines/interrupt-at.sh LOG ROWS CONDITION COMMAND...
set -euo pipefail
log=$1 rows=$2 condition=$3
shift 3

reached() {
  awk -F, -v "rows=$rows" 'NR > 1 && NF >= 22 { time = $1; fx = $8; fy = $9; fz = $10; if ('"$condition"') n++ }
    END { exit n < rows }' "$log"
}

set -m # the command gets a process group of its own, as in a terminal
"$@" &
process=$!
while kill -0 "$process" 2>/dev/null; do
  if [ -f "$log" ] && reached; then
    kill -INT -- "-$process" 2>/dev/null || true
    break
  fi
  sleep 0.1
done
wait "$process"
