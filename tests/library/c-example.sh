#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The C example with the simulated device.
# Usage: c-example.sh EXAMPLE
set -euo pipefail

# A hand 12.5 mm to the right is pulled to the left by 40 N/m.
output=$("$1" sim hold:0.5,0,0)
echo "$output"
grep -qE '^simulated SPIDAR-G .*, libspidar [0-9.]+$' <<<"$output"
grep -qE '^grip at 1[12]\.[0-9] .*, force -0\.[45][0-9] ' <<<"$output"

if refusal=$("$1" serial 2>&1); then
  echo "FAILED: it opened a device that is not known"
  exit 1
fi
grep -q "'serial' is not known" <<<"$refusal"
