#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Checks the model of the guardian's protocol, spidar/guardian/guardian.pml, with Spin in its whole state space: no
# force is left without a process and a guardian that both go on. Each known mistake must have a counter-example, so
# that the check is not blind, and the model must be that of the protocol's version in guardian-protocol.hpp.
# Prints the number of states of each. Exit status 77 without Spin.
#
# Usage: tests/referees/guardian-model.sh

set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
model=$root/spidar/guardian/guardian.pml
header=$root/spidar/src/guard/guardian-protocol.hpp

for command in spin cc; do
  command -v "$command" >/dev/null || { echo "SKIPPED: $command is not installed (spin, gcc)" && exit 77; }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
failed=0

version=$(sed -nE 's/.*kGuardianVersion = (0x[0-9a-f]+);.*/\1/p' "$header")
if [ -z "$version" ] || ! grep -q "^ \* Version: $version," "$model" || ! grep -q "model of this version, $version," "$header"; then
  echo "FAILED: guardian.pml is not the model of version '$version': change the model first, then its version"
  failed=1
fi

# `verify BROKEN NAME OPTION...`: searches everything, and expects that no assertion is broken, or the one with this text.
verify() {
  local expected=$1 name=$2 broken
  shift 2
  spin -a "$@" "$model" >spin.log
  # The process and the guardian may stand still (`provided`), which partial order reduction does not allow.
  cc -O2 -DSAFETY -DNOREDUCE -DCOLLAPSE -DMEMLIM=4000 -o pan pan.c
  ./pan -E -m2000000 >pan.log # -E: in the end all may stand still
  broken=$(sed -nE 's/^pan:1: assertion violated (.*) \(at depth.*/\1/p' pan.log)
  echo "$name: $(sed -nE 's/^ *([0-9]+) states, stored$/\1/p' pan.log) states${broken:+, a counter-example}"
  if [ -n "$expected" ]; then
    [[ $broken == *"$expected"* ]] && return
  else
    # A search that ran out of depth or memory has not seen everything.
    grep -q 'errors: 0$' pan.log && ! grep -qE 'depth too small|not completed|out of memory' pan.log && return
  fi
  cat pan.log
  failed=1
}

force='motors==0'
verify '' "a controller without replies"
verify '' "a controller that takes nothing while 4 replies are unread" -DUNREAD=4
verify "$force" "version 0x13, which rests once" -DOLD
verify 'known==intervention' "any word ends the intervention" -DANYWORD
verify "$force" "a force may follow a word that was not sent" -DUNTOLD
verify "$force" "the guardian reads no replies" -DUNREAD=4 -DDEAF

[ "$failed" = 0 ] && echo "passed"
exit "$failed"
