#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# What changes/join.sh makes of the changelog. Usage: changes-test.sh SOURCES
sources=$1
source "$(dirname "$0")/../support/promise.sh"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit
mkdir -p changes pipelines/shared
cp "$sources/changes/join.sh" changes
cp "$sources/pipelines/shared/common.sh" pipelines/shared

# `begin VERSION HEADING`: a project of that version, whose changelog begins with that heading.
begin() {
  printf "project('wind', 'cpp',\n  version: '%s',\n  meson_version: '>= 1.0.0',\n)\n" "$1" >meson.build
  printf '# Changelog\n\n%s\n\nMost recent first.\n\n* Old.\n\n## 0.0.1\n\n* Oldest.\n' "$2" >CHANGELOG.md
  rm -f changes/*.md
  echo '# How' >changes/README.md
  printf '* A \\n [link](../docs/force.md).\n' >changes/a.md
  printf '* B\n  goes on.\n\n* C.\n' >changes/b.md
  cp CHANGELOG.md before
}
is() { diff CHANGELOG.md <(printf '%s\n' "$@"); }
refused() { ! changes/join.sh 2>said && grep -qF "$1" said && cmp CHANGELOG.md before; }

begin 0.1.0 '## 0.1.0 (unreleased)'
promise "fragments are joined" changes/join.sh
promise "above the older entries of an unreleased version, which is released then" is '# Changelog' '' '## 0.1.0' '' \
  'Most recent first.' '' '* A \n [link](docs/force.md).' '* B' '  goes on.' '* C.' '* Old.' '' '## 0.0.1' '' '* Oldest.'
promise "and only the explanation is left" [ "$(echo changes/*.md)" = changes/README.md ]
cp CHANGELOG.md before
promise "without a fragment nothing is joined" refused 'write changes/NAME.md'

begin 0.2.0 '## 0.1.0'
promise "a version that the changelog does not have" changes/join.sh
promise "begins it" is '# Changelog' '' '## 0.2.0' '' '* A \n [link](docs/force.md).' '* B' '  goes on.' '* C.' '' \
  '## 0.1.0' '' 'Most recent first.' '' '* Old.' '' '## 0.0.1' '' '* Oldest.'

begin 0.1.0 '## 0.1.0'
promise "a released version gets no more" refused 'raise the version'
promise "and the fragments stay" [ -f changes/a.md ]

begin 0.1.0 '## 0.1.0 (unreleased)'
echo 'No entry.' >changes/c.md
promise "a line that is no entry is named" refused 'changes/c.md:1:No entry.'

begin 0.1.0 '## 0.1.0 (unreleased)'
sed -i '/^\*/d' CHANGELOG.md
cp CHANGELOG.md before
promise "no fragment is lost in a changelog without entries" refused 'has no place'

begin 0.1.0 '## 0.1.0 (unreleased)'
rm changes/[ab].md
cp "$sources"/changes/*.md changes
joins_all() { [ "$(echo changes/*.md)" = changes/README.md ] || changes/join.sh; }
promise "the fragments of this project can be joined" joins_all
