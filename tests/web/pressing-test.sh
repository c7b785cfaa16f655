#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A thing of a film is held in Chromium and, where it is there, in Firefox.
#
# From the environment: FEELING_WIND_BUILD, WEB_PACKAGES (the folder of npm's packages). SCREENSHOTS=FOLDER keeps
# pictures of the page.

source "$(dirname "$0")/../pipelines/support.sh"

here=$root/tests/web
command -v node >/dev/null || skip "node is not installed"
command -v chromium >/dev/null || skip "chromium is not installed"
[ -d "$WEB_PACKAGES/node_modules/puppeteer-core" ] || skip "npm has not fetched puppeteer-core (no network, or no npm)"
web=$build/pipelines/web
wind_film=$build/pipelines/films/wind-film
haptic_track=$build/gst-plugins/track/tools/haptic-track
[ -x "$wind_film" ] || skip "wind-film is not built"

films=$work/films
mkdir "$films"
promise "a film is drawn" "$wind_film" --width 640 --height 360 --rate 30 --duration 20 "$work/film.ts"
promise "the sets of its track" "$haptic_track" convert "$work/film.ts" "$work/track.klv"
promise "a thing among them" node "$here/add-things.mjs" "$work/track.klv" 30 "$work/things.klv"
ffmpeg -v error -i "$work/film.ts" -map 0:v -c copy -avoid_negative_ts make_zero \
  -movflags +frag_keyframe+empty_moov+default_base_moof "$work/film.mp4" </dev/null
promise "CMAF with it" node "$here/make-cmaf.mjs" "$work/film.mp4" 30 "$films" held "$work/things.klv"
element=
if [ -f "$web/player/feeling-wind.min.js" ]; then
  element=$work/element
  mkdir "$element"
  cp "$web/single.html" "$element/index.html"
  cp "$web/player/feeling-wind.min.js" "$element"
  cp "$work/things.klv" "$element/film.klv"
  ffmpeg -v error -i "$work/film.ts" -map 0:v -c copy -movflags +faststart "$element/film.mp4" </dev/null
fi
node "$here/pressing-test.mjs" "$web" "$films" "$element" "${SCREENSHOTS:-}"
