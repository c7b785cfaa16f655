#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Every link between the pages leads to an existing file and, where it names one, an existing heading.
# Every address is the maintainer's.
set -euo pipefail
cd "$(dirname "$0")/../.."

# Prints the headings of a page as link targets: lower case, no punctuation, dashes for spaces.
anchors() {
  sed -n 's/^#\+ \+//p' "$1" | tr '[:upper:]' '[:lower:]' | sed 's/[^a-z0-9 _-]//g; s/ /-/g'
}

broken=0 count=0
complain() {
  echo "$page: the link '$target' leads $1"
  broken=1
}

while IFS= read -r page; do
  while IFS= read -r target; do
    case $target in
    http:* | https:*) continue ;;
    mailto:*)
      grep '^Maintainer:' debian/control | grep -qF "<${target#mailto:}>" || complain "to nobody in debian/control"
      continue
      ;;
    esac
    count=$((count + 1))
    file=${target%%#*}
    if [ -n "$file" ]; then
      file=$(dirname "$page")/$file
    else
      file=$page
    fi
    if [ ! -e "$file" ]; then
      complain "nowhere"
    elif [[ $target == *#* ]] && ! anchors "$file" | grep -qxF -- "${target#*#}"; then
      complain "to a heading that is not there"
    fi
  done < <(grep -o '](\([^)]*\))' "$page" | sed 's/^](//; s/)$//')
done < <(printf '%s\n' *.md changes/*.md; find docs -name '*.md')

echo "$count links checked"
[ "$count" -gt 0 ] && [ "$broken" = 0 ]
