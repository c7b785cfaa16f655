#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Every filter of cases on the pages finds a case: GoogleTest calls it a success when none runs. So does each of those that
# tests/support/repetitions.sh leaves out, which would run otherwise.
# Usage: named-cases.sh BUILD
set -euo pipefail
shopt -s globstar
cd "$(dirname "$0")/../.."

wrong=0 count=0
while IFS=: read -r page command; do
  count=$((count + 1))
  program=${command%% *} filter=${command#*\'}
  [ -n "$("$1/${program#*/}" --gtest_list_tests --gtest_filter="${filter%\'}")" ] && continue
  echo "$page: $command has no case"
  wrong=$((wrong + 1))
done < <(grep -oE "\bbuild(-tests)?/tests/[a-z/-]+ --gtest_filter='[^']*'" README.md CONTRIBUTING.md docs/**/*.md)

names=$(find "$1"/tests/{unit,elements,faults,usb} -maxdepth 1 -type f -executable -exec {} --gtest_list_tests \; 2>/dev/null |
  awk '/^[^ ]+\.( |$)/ { suite = $1 } /^  [^ ]/ { print suite $1 }')
source tests/support/repetitions.sh
for pattern in "${repetitions[@]}"; do
  count=$((count + 1))
  expression=${pattern//./\\.}
  grep -qxE -- "${expression//\*/.*}" <<<"$names" && continue
  echo "tests/support/repetitions.sh: $pattern is no case"
  wrong=$((wrong + 1))
done
echo "$count filters, $wrong wrong"
[ "$wrong" = 0 ] && [ "$count" -gt 10 ]
