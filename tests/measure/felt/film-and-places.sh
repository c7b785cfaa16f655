# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034,SC2154 # for the scripts that source it, with common.sh before
# What measures of whole films share: $program, which draws them, a folder $work that goes, 15 $places, and version_of.

program=$build/pipelines/films/wind-film
[ -x "$program" ] || fail "'$program' is not built: meson compile -C $build"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
find_plugins

# `version_of FILE...` stands in the name of a film that these programs drew: another version draws it anew.
version_of() {
  cat "$@" | sha256sum | head -c 8
}

places=
for x in 0.1 0.3 0.5 0.7 0.9; do
  for y in 0.167 0.5 0.833; do places+=" $x,$y"; done
done
