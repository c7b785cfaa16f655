#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# All programs succeed and print the same. One for AVX-512 runs only where the processor has it.
# Usage: same-output.sh PROGRAM PROGRAM...
set -euo pipefail
wanted=$("$1")
shift
for program; do
  if [[ $program == *avx512f ]] && ! grep -qw avx512f /proc/cpuinfo; then
    echo "not run, for this processor has no AVX-512: $program"
    continue
  fi
  got=$("$program")
  diff <(echo "$wanted") <(echo "$got") || {
    echo "$program differs: the layout of a public struct depends on the user's compiler options."
    exit 1
  }
done
