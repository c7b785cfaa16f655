#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws how stiff and how damped a wall each device can hold under a hand, in virtual time; dashed, the
# theory of a wall without delay. Takes several minutes.
#
# Usage: tests/measure/force/z-width.sh PICTURE.png
#
# Takes the program from build/, which needs the option -Dtests=enabled.

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

case ${1:-} in
--help | -h) show_help && exit ;;
esac
[ $# = 1 ] || fail "there is no picture to write; name one, see --help"
program=$build/tests/measure/force/z-width
[ -x "$program" ] ||
  fail "'$program' is not built: meson configure $build -Dtests=enabled && meson compile -C $build"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

panels=()
for panel in geometry hand rate lateness; do
  "$program" "$panel" >"$work/$panel.txt" &
  panels+=($!)
done
for panel in "${panels[@]}"; do
  wait "$panel" || fail "a panel could not be measured; see above"
done
gnuplot -c "$root/tests/measure/force/z-width.gp" "$work" "$1"
echo "$1"
