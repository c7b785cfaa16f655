#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# docs/troubleshooting.md knows every error and warning: of each message in the sources a part (of two
# words at least) stands there in the first column as `code`.
# shellcheck disable=SC2016 # the backticks and dollars are those of the page and of the sources

set -euo pipefail
cd "$(dirname "$0")/../.."
export LC_ALL=C.UTF-8
known=$(mktemp)
trap 'rm -f "$known"' EXIT
awk -F'|' '/^\|/ { print $2 }' docs/troubleshooting.md | grep -o '`[^`]*`' | tr -d '`' | grep ' ' >"$known"

# `statements PATTERN FILE...`: from each place where a message begins to the end of the statement, on one line.
statements() {
  local pattern=$1
  shift
  grep -hPzo "(?s)\b(?:$pattern)\((?:\"(?:\\\\.|[^\"\\\\])*\"|[^;\"])*;" "$@" | tr '\n\0' ' \n'
}

# The texts alone of a statement in C++, one statement a line.
texts() {
  sed -E 's/"[[:space:]]+"//g; s/\\"/'\''/g' | while IFS= read -r statement; do
    grep -o '"[^"]*"' <<<"$statement" | tr -d '"\n' || true
    echo
  done
}

count=0 missing=0
while IFS= read -r message; do
  [[ $message =~ [[:alpha:]]{3,}.*[[:space:]].*[[:alpha:]]{3,} ]] || continue # it hands on what another says
  count=$((count + 1))
  grep -qF -f "$known" <<<"$message" || { echo "not in docs/troubleshooting.md: $message" && missing=$((missing + 1)); }
done < <(
  find gst-plugins spidar pipelines -name '*.[ch]pp' -print0 |
    xargs -0 bash -c "$(declare -f statements)"'; statements "GST_ELEMENT_(?:ERROR|WARNING|INFO)|throw (?:spidar::)?Error|throw TrackFileError|complain|tell" "$@"' - | texts
  statements fail gst-plugins/track/tools/*.cpp pipelines/view/*.cpp | texts
  grep -hoP '\bfail "\K([^"\\]|\\.)*' pipelines/*.sh | sed -E 's/\$(\{[^}]*\}|\(.*)//g'
)
echo "$count messages, $missing not explained"
[ "$count" -gt 100 ] && [ "$missing" = 0 ]
