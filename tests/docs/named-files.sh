#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The files and functions that docs/architecture.md names below "Find the line" exist.
set -euo pipefail
cd "$(dirname "$0")/../.."
page=docs/architecture.md
wrong=0 count=0

complain() {
  echo "$page: $*"
  wrong=$((wrong + 1))
}

# Prints the words in backticks of its argument, one a line.
# shellcheck disable=SC2016 # the backticks are those of the page
words() {
  grep -o '`[^`]*`' <<<"$1" | tr -d '`'
}

# Prints the rows of the tables below a heading, without their heads.
rows() {
  awk -v heading="$1" '
    /^#/ { inside = $0 == heading; body = 0 }
    inside && /^\|---/ { body = 1; next }
    inside && body && /^\|/' "$page"
}

while IFS='|' read -r _ _ file functions _; do
  file=$(words "$file")
  [ -f "$file" ] || { complain "there is no file $file" && continue; }
  while read -r function; do
    count=$((count + 1))
    grep -qE "\b$function\(" "$file" || complain "there is no function $function in $file"
  done < <(words "$functions")
done < <(rows '## Find the line')

echo "$count names checked, $wrong wrong"
[ "$count" -gt 20 ] && [ "$wrong" = 0 ]
