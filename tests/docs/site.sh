#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The site of the pages builds without a warning, its links lead somewhere, and its search knows every page.
# Usage: site.sh SOURCES
set -euo pipefail
source "$(dirname "$0")/../support/promise.sh"
command -v mkdocs >/dev/null || skip "mkdocs is not installed (package mkdocs-material)"
[ -d /usr/share/mkdocs/themes/material ] || [ -d /usr/lib/python3/dist-packages/material ] ||
  skip "the theme is not installed (package mkdocs-material)"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
build() { mkdocs build --quiet --strict --config-file "$1/mkdocs.yml" --site-dir "$work/site" >"$work/log" 2>&1 || { cat "$work/log"; return 1; }; }
promise "it builds without a warning" build "$1"
promise "its links lead somewhere" "$(dirname "$0")/site-links.py" "$work/site"
searched() {
  /usr/bin/python3 -c 'import json, sys
index = {entry["location"].split("#")[0] for entry in json.load(open(sys.argv[1]))["docs"]}
print(len(index), "pages")
sys.exit(len(index) < 40 or "elements/hapticsink.html" not in index)' "$work/site/search/search_index.json"
}
promise "its search knows every page" searched
