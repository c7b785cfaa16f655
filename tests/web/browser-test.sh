#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The player of pipelines/web in Chromium and, where it is there, in Firefox, with a film that the build draws.
#
# From the environment: FEELING_WIND_BUILD, WEB_PACKAGES (the folder of npm's packages). SCREENSHOTS=FOLDER keeps
# pictures of the page. RATES_SECONDS=60 compares the browsers' forces for so long in the place of 5 s.

source "$(dirname "$0")/../pipelines/support.sh"

here=$root/tests/web
command -v node >/dev/null || skip "node is not installed"
command -v chromium >/dev/null || skip "chromium is not installed"
[ -d "$WEB_PACKAGES/node_modules/puppeteer-core" ] || skip "npm has not fetched puppeteer-core (no network, or no npm)"
[ -f "$build/pipelines/web/player/hls.worker.js" ] || skip "the build has no hls.js; run meson setup --reconfigure after npm"
wind_film=$build/pipelines/films/wind-film
haptic_track=$build/gst-plugins/track/tools/haptic-track
[ -x "$wind_film" ] || skip "wind-film is not built"

# `playlist NAME PART...`: a playlist of parts of 20 s.
playlist() {
  local name=$1 part
  shift
  {
    printf '#EXTM3U\n#EXT-X-VERSION:3\n#EXT-X-TARGETDURATION:21\n#EXT-X-PLAYLIST-TYPE:VOD\n'
    for part; do
      printf '#EXT-X-DISCONTINUITY\n#EXTINF:20.0,\n%s\n' "$part"
    done
    echo '#EXT-X-ENDLIST'
  } >"$films/$name.m3u8"
}

films=$work/films
mkdir "$films"
cp "$here"/{embed,follow}.{html,js} "$here/blank.html" "$films"
promise "a film is drawn" "$wind_film" --width 640 --height 360 --rate 30 --duration 20 "$films/film.ts"
ffmpeg -v error -ss 4 -i "$films/film.ts" -frames:v 1 "$films/poster.jpg" </dev/null
ffmpeg -v error -i "$films/film.ts" -map 0:v -c copy "$films/no-track.ts" </dev/null
promise "a track alone" "$haptic_track" convert "$films/film.ts" "$films/track-only.ts"
cp "$films/film.ts" "$films/damaged.ts"
head -c 30000 /dev/urandom | dd of="$films/damaged.ts" bs=1000 seek=1000 conv=notrunc status=none
for name in film no-track track-only damaged; do
  playlist "$name" "$name.ts"
done

promise "a short film is drawn" "$wind_film" --width 640 --height 360 --rate 30 --duration 8 "$films/sink.ts"
playlist sink sink.ts
promise "and felt by hapticsink" gst-launch-1.0 -q filesrc "location=$films/sink.ts" ! tsdemux ! meta/x-klv ! hapticconvert \
  ! hapticsink device=sim sim-hand=hold:-0.16,0.16,0 alpha=0.04 "log-location=$work/sink.csv"

playlist stalls film.ts never.ts
playlist part-missing missing.ts
playlist part-elsewhere https://elsewhere.invalid/part.ts
playlist key-elsewhere film.ts
sed -i '/^#EXTINF/i #EXT-X-KEY:METHOD=AES-128,URI="https://elsewhere.invalid/key"' "$films/key-elsewhere.m3u8"

# `cmaf_of FILM.ts FOLDER`: cmaf.m3u8 in FOLDER, and beside FILM.ts the film and the sets of its track.
cmaf_of() {
  local name=${1%.ts}
  "$haptic_track" convert "$1" "$name.klv" &&
    ffmpeg -v error -i "$1" -map 0:v -c copy -avoid_negative_ts make_zero \
      -movflags +frag_keyframe+empty_moov+default_base_moof "$name.mp4" </dev/null &&
    node "$here/make-cmaf.mjs" "$name.mp4" 30 "$2" cmaf "$name.klv"
}
cp "$films/film.ts" "$work"
promise "CMAF with the track" cmaf_of "$work/film.ts" "$films"
# A ball in relief, as its own picture: it rolls to and fro.
ffmpeg -v error -f lavfi -i "color=gray:160x90:r=30:d=20,format=gray,geq=lum='30+200*sqrt(max(0,1-(pow(X-80-30*sin(T),2)+pow(Y-45,2))/900))'" \
  -vf scale=640:360 -c:v libx264 -pix_fmt yuv420p -g 30 -movflags +frag_keyframe+empty_moov+default_base_moof "$work/ball.mp4" </dev/null
promise "reliefs of a ball" gst-launch-1.0 -q filesrc "location=$work/ball.mp4" ! qtdemux ! avdec_h264 ! videoconvert \
  ! video/x-raw,format=GRAY8 ! depthfield kind=disparity scale=255 near=1 far=255 range=0.03 ! hapticconvert ! meta/x-klv \
  ! filesink "location=$work/reliefs.klv"
promise "the ball as a film with a surface" gst-launch-1.0 -q mpegtsmux name=mux ! filesink "location=$work/ball.ts" \
  filesrc "location=$work/ball.mp4" ! qtdemux ! h264parse ! tee name=film film. ! queue ! mux. film. ! queue ! avdec_h264 \
  ! videoconvert ! video/x-raw,format=GRAY8 ! depthfield kind=disparity scale=255 near=1 far=255 range=0.03 ! hapticconvert \
  ! meta/x-klv ! queue ! mux.
promise "packaged as a transport stream" env FEELING_WIND_WEB="$build/pipelines/web" \
  "$haptic_track" package --carriage ts --output "$films/ball" "$work/ball.ts"
promise "a film to be touched" node "$here/make-cmaf.mjs" "$work/ball.mp4" 30 "$films" ball "$work/reliefs.klv"
promise "one with motion and surface" node "$here/make-cmaf.mjs" "$work/film.mp4" 30 "$films" both "$work/film.klv" "$work/reliefs.klv"
if [ -f "$build/pipelines/web/player/feeling-wind.min.js" ]; then
  ffmpeg -v error -i "$films/film.ts" -map 0:v -c copy -movflags +faststart "$work/single.mp4" </dev/null
  promise "a film with its track as one file beside it" env FEELING_WIND_WEB="$build/pipelines/web" \
    "$haptic_track" package --single --output "$work/single" "$work/single.mp4"
fi
promise "a film in five segments" env FEELING_WIND_WEB="$build/pipelines/web" \
  "$haptic_track" package --output "$films/packaged" "$films/film.ts"
sed 's|cmaf-header.mp4|https://elsewhere.invalid/header.mp4|' "$films/cmaf.m3u8" >"$films/map-elsewhere.m3u8"

printf '#EXTM3U\n#EXT-X-STREAM-INF:BANDWIDTH=1000000\nhttps://elsewhere.invalid/film.m3u8\n' >"$films/list-elsewhere.m3u8"
head -c 5000 /dev/urandom >"$films/noise.m3u8"

without=$work/without-hls
cp -r "$build/pipelines/web" "$without"
rm "$without"/player/hls.*
cp "$root/pipelines/web/player/hls.light.min.js" "$without/player"

rates_films=$films
if [ "${RATES_SECONDS:-5}" -gt 15 ]; then
  rates_films=$work/rates
  mkdir "$rates_films"
  cp "$here/blank.html" "$rates_films"
  promise "a longer film is drawn" "$wind_film" --width 640 --height 360 --rate 30 --duration $((RATES_SECONDS + 5)) "$work/rates.ts"
  promise "and made CMAF" cmaf_of "$work/rates.ts" "$rates_films"
fi
node "$here/rates-test.mjs" "$build/pipelines/web" "$rates_films" "${RATES_SECONDS:-5}"
node "$here/blown-test.mjs" "$build/pipelines/web" "$films"
if [ -d "$work/single" ]; then
  node "$here/element-test.mjs" "$work/single"
  node "$here/lines-test.mjs" "$build/pipelines/web" "$work/single" "$films/packaged"
fi
node "$here/browser-test.mjs" "$build/pipelines/web" "$films"
node "$here/sink-test.mjs" "$build/pipelines/web" "$films" "$work/sink.csv" "$work/page.csv"
share=$("$haptic_track" compare --json "$work/page.csv" "$work/sink.csv" | sed -n 's/.*"distinguishable": *\([0-9.]*\).*/\1/p')
promise "a hand could tell them apart for $share of the time, less than 0.05" awk "BEGIN { exit !($share < 0.05) }"
node "$here/without-device-test.mjs" "$build/pipelines/web" "$films"
node "$here/page-test.mjs" "$build/pipelines/web" "$films" "${SCREENSHOTS:-}"
node "$here/relief-test.mjs" "$build/pipelines/web" "$films" "$without" "${SCREENSHOTS:-}"
node "$here/bad-input-test.mjs" "$build/pipelines/web" "$films" "$without"
node "$here/embed-test.mjs" "$build/pipelines/web" "$films" "$without"
