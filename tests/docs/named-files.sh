#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The files that docs/architecture.md names exist, and so do the functions of its list "Find the line".
# Every source file of the rooms but messages.hpp is in one of its tables.
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

for room in gst-plugins/common gst-plugins/vision gst-plugins/track gst-plugins/device spidar/src spidar/emulator pipelines; do
  named=$(rows "### $room" | cut -d'|' -f2)
  while read -r name; do
    count=$((count + 1))
    compgen -G "$room/$name" >/dev/null || compgen -G "$room/$name.*" >/dev/null || complain "there is no file $room/$name"
  done < <(words "$named")
  while read -r file; do
    file=${file#"$room"/}
    words "$named" | grep -qxF -e "$file" -e "${file%.*}" || complain "$room/$file is not in the table"
  done < <(find "$room" ! -name messages.hpp \( -name "*.[ch]pp" -o -name "*.h" -o -name "*.js" \))
done

echo "$count names checked, $wrong wrong"
[ "$count" -gt 50 ] && [ "$wrong" = 0 ]
