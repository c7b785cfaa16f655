#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Moves the fragments in this folder into CHANGELOG.md, below the version that meson.build states.
# Run it once for each release, after the version was raised.
#
# Usage: changes/join.sh

source "$(dirname "$0")/../pipelines/shared/common.sh"

case ${1:-} in
'') ;;
--help | -h) show_help && exit ;;
*) fail "unknown option '$1'; see --help" ;;
esac
cd "$root"

fragments=()
for file in changes/*.md; do
  [ "$file" = changes/README.md ] || fragments+=("$file")
done
[ ${#fragments[@]} -gt 0 ] || fail "no change to join; write changes/NAME.md first"
if wrong=$(grep -HnvE '^(\* .|  .|$)' "${fragments[@]}"); then
  fail "this line is no entry: ${wrong%%$'\n'*}; begin it with '* ', or with two spaces if it continues an entry"
fi
version=$(sed -n "/^project(/,/)/ s/^ *version: '\([^']*\)',.*/\1/p" meson.build)
[ -n "$version" ] || fail "meson.build states no version; write it in project()"
! grep -qxF "## $version" CHANGELOG.md || fail "$version is released already; raise the version in meson.build"

# A fragment lies one folder deeper than the changelog.
entries=$(sed -e '/^$/d' -e 's|](\.\./|](|g' "${fragments[@]}")
joined=$(heading="## $version" entries=$entries awk '
  BEGIN { heading = ENVIRON["heading"]; entries = ENVIRON["entries"] }
  !section && /^## / {
    section = $0 == heading " (unreleased)" ? "old" : "new"
    if (section == "new")
      print heading "\n\n" entries "\n"
    else
      $0 = heading
  }
  section == "old" && /^\* / { print entries; section = "done" }
  { print }' CHANGELOG.md)
[[ $joined == *"$entries"* ]] ||
  fail "the changelog has no place for entries; write '## $version (unreleased)' and an entry into it"
printf '%s\n' "$joined" >CHANGELOG.md
rm "${fragments[@]}"
echo "CHANGELOG.md has ${#fragments[@]} fragments more below $version"
