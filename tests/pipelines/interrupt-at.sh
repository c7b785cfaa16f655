#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs a command and interrupts it, as Ctrl-C in a terminal does, once hapticsink's log has reached a running time.
#
# Usage: tests/pipelines/interrupt-at.sh LOG SECONDS COMMAND...
set -euo pipefail
log=$1 seconds=$2
shift 2

reached() {
  tail -n 1 "$log" | awk -F, -v "at=$seconds" '{ there = NF >= 22 && $1 + 0 >= at } END { exit !there }'
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
