#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# screenshots.sh takes the pictures of the program and of the web page.

source "$(dirname "$0")/support.sh"
for program in xvfb-run xdotool openbox ffmpeg chromium node; do
  command -v $program >/dev/null || skip "$program is not installed"
done
[ -d "$root/build-web/node_modules/puppeteer-core" ] || skip "npm has not fetched puppeteer-core (no network, or no npm)"
[ -x "$build/pipelines/feeling-wind/feeling-wind" ] || skip "the program is not built"
gst-inspect-1.0 --exists webpdec || skip "webpdec is not installed (package gstreamer1.0-plugins-bad)"

take() { "$root/pipelines/paper/screenshots.sh" "$work" >"$work/said" 2>&1 || { cat "$work/said"; return 1; }; }
promise "one command takes them" take
# `pixels NAME CONDITION`: of so many pixels the colour fulfils the awk condition on r, g and b.
pixels() {
  gst-launch-1.0 -q filesrc "location=$work/$1.webp" ! webpdec ! videoconvert ! video/x-raw,format=RGB ! fdsink |
    od -An -v -tu1 -w3 | awk "{ r = \$1; g = \$2; b = \$3 } $2 { n++ } END { print n + 0 }"
}
for picture in program program-dark program-fullscreen program-array touch-colour page page-playing page-hold page-phone; do
  promise "$picture.webp shows the tree" test "$(pixels $picture 'g > r + 15 && g > b + 30')" -ge 10000
done
promise "the full screen has no title bar: more of it is film" \
  test "$(pixels program-fullscreen 'r > 230 && g > 230 && b > 230')" -le "$(pixels program 'r > 230 && g > 230 && b > 230')"
promise "touch-depth.webp shows a ball" test "$(pixels touch-depth 'b > r + 60 && b > g + 40')" -ge 1000
for picture in "$work"/*.webp; do
  promise "${picture##*/} is at most 70 kB" test "$(wc -c <"$picture")" -le 70000
done
promise "program.webp shows the velocity in orange" test "$(pixels program 'r > 130 && r > b + 100 && g < r - 20')" -ge 300
promise "program-dark.webp is dark around the film" test "$(pixels program-dark 'r < 70 && r == g && g == b')" -ge 50000
promise "program-empty.webp is light and has no film" test "$(pixels program-empty 'r > 230 && g > 230 && b > 230')" -ge 300000
