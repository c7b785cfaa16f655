#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Every filter of cases on the pages finds a case: GoogleTest calls it a success when none runs.
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
echo "$count filters, $wrong wrong"
[ "$wrong" = 0 ] && [ "$count" -gt 10 ]
