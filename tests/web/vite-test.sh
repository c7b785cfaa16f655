#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A stranger's page: the npm package of the player in a project of Vite, without hls.js and with it, and beside Shaka
# Player, in each browser that is there. Needs a network: npm fetches Vite, hls.js and Shaka Player.

source "$(dirname "$0")/../pipelines/support.sh"

here=$root/tests/web
haptic_track=$build/gst-plugins/track/tools/haptic-track
player=$build/pipelines/web/player
for command in node npm ffmpeg; do
  command -v "$command" >/dev/null || skip "$command is not installed"
done
[ -d "$WEB_PACKAGES/node_modules/puppeteer-core" ] || skip "npm has not fetched puppeteer-core (no network, or no npm)"
[ -f "$player/feeling-wind.min.js" ] || skip "esbuild is not installed, and --single needs the player in one file"
export FEELING_WIND_WEB=$build/pipelines/web

cd "$work" || exit 1
echo '{ "private": true, "type": "module" }' >package.json
npm pack --silent "$player" >/dev/null
npm install --ignore-scripts --no-audit --no-fund --loglevel=error vite@8.3.8 ./feeling-wind-*.tgz >/dev/null ||
  skip "npm cannot fetch Vite (no network)"
promise "hls.js does not come with the player" test ! -e node_modules/hls.js

promise "a film is drawn" "$build/pipelines/films/wind-film" --width 640 --height 360 --rate 30 --duration 8 film.ts
ffmpeg -v error -i film.ts -map 0:v -c copy -movflags +faststart film.mp4 </dev/null
promise "its track is one file" "$haptic_track" package --single --output single film.mp4
promise "or in segments that need hls.js" "$haptic_track" package --carriage ts --output segments film.ts

# `project NAME FILMS`: builds the page of main.js into NAME/dist, with the files of FILMS beside it.
project() {
  local name=$1
  mkdir -p "$name/public"
  cp -r "$2"/film.* "$name/public"
  [ ! -d "$2/player" ] || cp -r "$2"/ts-* "$name/public"
  cat >"$name/index.html"
  npx vite build --logLevel error --base ./ "$name"
}

promise "ten lines are built without hls.js" project plain single <<'END'
<!DOCTYPE html>
<title>My film</title>
<script type="module">import 'feeling-wind/element';</script>
<feeling-wind src="film.mp4" track="film.klv">Serve me: http://localhost</feeling-wind>
END
promise "and are felt" node "$here/element-test.mjs" "$work/plain/dist"

npm install --ignore-scripts --no-audit --no-fund --loglevel=error hls.js@1.7.4 >/dev/null
promise "so are ten lines with hls.js" project hls segments <<'END'
<!DOCTYPE html>
<title>My long film</title>
<body>Serve me: http://localhost
<script type="module">
  import 'feeling-wind/hls';
  import 'feeling-wind/element';
  const film = document.createElement('feeling-wind');
  film.hlsConfig = { enableWorker: false }; // whose blob: the policy of this site refuses
  film.setAttribute('src', 'film.m3u8');
  document.body.append(film);
</script>
END
# hls.js makes the text tracks that carry metadata from data:.
promise "and are felt" node "$here/element-test.mjs" "$work/hls/dist" data:

npm install --ignore-scripts --no-audit --no-fund --loglevel=error shaka-player@5.2.12 >/dev/null
promise "in segments of MP4" "$haptic_track" package --output packaged film.ts
promise "with Shaka Player by the lines of docs/web.md" node "$here/lines-test.mjs" "$build/pipelines/web" \
  "$work/single" "$work/packaged" "$work/node_modules/shaka-player/dist/shaka-player.compiled.js"
