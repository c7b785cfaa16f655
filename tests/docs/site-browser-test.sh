#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The site with its film, as it is published, in Chromium: weight, width on a telephone, accessibility.
#
# From the environment: FEELING_WIND_BUILD, WEB_PACKAGES (the folder of npm's packages).

source "$(dirname "$0")/../pipelines/support.sh"
for program in node chromium mkdocs ffmpeg; do
  command -v $program >/dev/null || skip "$program is not installed"
done
[ -d "$WEB_PACKAGES/node_modules/puppeteer-core" ] || skip "npm has not fetched puppeteer-core (no network, or no npm)"
[ -f "$build/pipelines/web/player/feeling-wind.min.js" ] || skip "the element is not built (package esbuild)"

build_site() { "$root/pipelines/web/site.sh" "$work/site" >"$work/said" 2>&1 || { cat "$work/said"; return 1; }; }
promise "one command builds it with its film" build_site
promise "its links lead somewhere" "$root/tests/docs/site-links.py" "$work/site"
node "$root/tests/docs/site-browser-test.mjs" "$work/site"
