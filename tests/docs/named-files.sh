#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The files, functions and names that the pages name exist.
set -euo pipefail
shopt -s globstar
cd "$(dirname "$0")/../.."
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

# `check_table HEADING BEHIND`: each row has a file, then names, which stand in the file before BEHIND.
check_table() {
  local file names name
  while IFS='|' read -r _ _ file names _; do
    file=$(words "$file")
    [ -f "$file" ] || { complain "there is no file $file" && continue; }
    while read -r name; do
      count=$((count + 1))
      grep -qE "\b$name$2" "$file" || complain "there is no $name in $file"
    done < <(words "$names")
  done < <(rows "$1")
}

page=docs/architecture.md
check_table '## Find the line' '(\(|\[|\{| +[=:\\])'
[ "$count" -gt 20 ] || complain "has only $count functions"

page=CONTRIBUTING.md
for what in 'a tracker' 'a device' 'a format' 'an element'; do
  before=$count
  check_table "### Add $what" '\b'
  [ "$count" -gt "$before" ] || complain "does not say how to add $what"
done

page=docs/pipelines.md
while IFS='|' read -r _ script _; do
  script=$(words "$script")
  [[ ${script%% *} != *.* ]] || [ -f "pipelines/${script%% *}" ] || complain "there is no script ${script%% *}"
  count=$((count + 1))
done < <(rows '# Pipelines')

# Headers that spidar installs are named as a program includes them.
for page in README.md CONTRIBUTING.md SECURITY.md docs/**/*.md; do
  while read -r name _; do
    [[ $name =~ ^(\./)?(changes|debian|docs|gst-plugins|pipelines|spidar|tests)/ ]] || continue
    count=$((count + 1))
    compgen -G "$name" >/dev/null || [ -e "spidar/include/$name" ] || [ -e "spidar/include/$name.in" ] ||
      complain "there is no $name"
  done < <(words "$(<"$page")" || true)
done

echo "$count names checked, $wrong wrong"
[ "$wrong" = 0 ]
