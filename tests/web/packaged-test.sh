#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The whole way: a film is drawn, packaged in both carriages, served by nginx as docs/web.md says, and felt in Chromium.

source "$(dirname "$0")/../pipelines/support.sh"
source "$(dirname "$0")/../pipelines/nginx.sh"

here=$root/tests/web
for command in node chromium nginx curl; do
  command -v "$command" >/dev/null || skip "$command is not installed"
done
[ -d "$WEB_PACKAGES/node_modules/puppeteer-core" ] || skip "npm has not fetched puppeteer-core (no network, or no npm)"
[ -f "$build/pipelines/web/player/hls.worker.js" ] || skip "the build has no hls.js; run meson setup --reconfigure after npm"
export FEELING_WIND_WEB=$build/pipelines/web

promise "a film is drawn" "$build/pipelines/films/wind-film" --width 640 --height 360 --rate 30 --duration 10 "$work/film.ts"
for carriage in cmaf ts; do
  promise "and packaged as $carriage" "$build/gst-plugins/track/tools/haptic-track" package --carriage "$carriage" \
    --output "$work/$carriage" "$work/film.ts"
done
promise "with the licences of what was copied" test -s "$work/cmaf/LICENSE" -a -s "$work/cmaf/player/LICENSE" \
  -a -s "$work/cmaf/player/hls.LICENSE.txt"
chmod -R a+rX "$work" # for the workers of a server that root starts
# For its start, `serve` wants the playlist of the folder itself.
cp "$work/cmaf/film.m3u8" "$work"
promise "nginx serves both" serve "$work"
for carriage in cmaf ts; do
  promise "two viewers of $carriage feel what each points at" node "$here/packaged-test.mjs" "http://$address" "$carriage"
done
