#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A packaged film from Debian's nginx, configured by the lines of docs/web.md, for one client and for a thousand.

source "$(dirname "$0")/support.sh"
source "$(dirname "$0")/nginx.sh"

haptic_track=$build/gst-plugins/track/tools/haptic-track
use_elements motionfield hapticconvert
for command in nginx curl python3 ffmpeg; do
  command -v "$command" >/dev/null || skip "$command is not installed"
done

export FEELING_WIND_WEB=$work/web
mkdir "$FEELING_WIND_WEB"
echo '<!DOCTYPE html><script type="module" src="player.js"></script>' >"$FEELING_WIND_WEB/index.html"
for ((i = 0; i < 200; i++)); do echo "export const line$i = $i;"; done >"$FEELING_WIND_WEB/player.js"
echo 'p { color: red }' >"$FEELING_WIND_WEB/style.css"
ffmpeg -v error -f lavfi -i testsrc2=s=320x240:r=25:d=12 -c:v libx264 -preset ultrafast -pix_fmt yuv420p -g 50 "$work/in.mp4"
for carriage in cmaf ts; do
  "$haptic_track" package --carriage "$carriage" --output "$work/$carriage" "$work/in.mp4" >/dev/null 2>&1
done
mkdir "$work/cmaf/.package"
echo secret >"$work/cmaf/.package/file"

lines() { [ "$(awk '/^```nginx$/ { open = 1; next } /^```$/ && open { exit } open' "$root/docs/web.md" | wc -l)" -le 14 ]; }
promise "the page has a dozen lines" lines
chmod -R a+rX "$work" # for the workers of a server that root starts
promise "nginx takes them" serve "$work"

# `head_has PATH TEXT...`: the head of the answer has lines that begin with these texts.
head_has() {
  local path=$1 text
  shift
  curl -sS -D "$work/head" -o "$work/body" -H 'Origin: http://elsewhere.example' "${options[@]}" "http://$address/$path"
  for text; do
    grep -qiF -- "$text" "$work/head" || { cat "$work/head"; return 1; }
  done
}
options=()
segment=$(cd "$work" && echo cmaf/mp4-*/00001.mp4)
stream=$(cd "$work" && echo ts/ts-*/00001.ts)
kept='Cache-Control: public, max-age=31536000, immutable'
promise "the page" head_has cmaf/index.html '200 OK' 'Content-Type: text/html' 'Cache-Control: no-cache' \
  "Content-Security-Policy: default-src 'none'; script-src 'self'" 'X-Content-Type-Options: nosniff'
promise "the player" head_has cmaf/player.js 'Content-Type: application/javascript' 'Cache-Control: no-cache'
promise "its looks" head_has cmaf/style.css 'Content-Type: text/css'
promise "the playlist, which may change" head_has cmaf/film.m3u8 'Content-Type: application/vnd.apple.mpegurl' \
  'Cache-Control: no-cache' 'Access-Control-Allow-Origin: *'
promise "the playlist of a rate" head_has "${segment%/*}/film.m3u8" 'Content-Type: application/vnd.apple.mpegurl' "$kept"
promise "a segment of MP4, which stays" head_has "$segment" 'Content-Type: video/mp4' "$kept" 'Access-Control-Allow-Origin: *'
promise "and of MPEG-TS" head_has "$stream" 'Content-Type: video/mp2t' "$kept"
promise "the poster" head_has cmaf/poster.jpg 'Content-Type: image/jpeg'
promise "nothing unsafe is allowed" bash -c "! curl -sI 'http://$address/cmaf/index.html' | grep -i unsafe"
promise "no hidden file" head_has cmaf/.package/file '404 Not Found'
options=(-r 100-299)
promise "a part of a segment" head_has "$segment" '206 Partial Content' 'Content-Range: bytes 100-299/' 'Content-Length: 200'
promise "which is that part" cmp "$work/body" <(tail -c +101 "$work/$segment" | head -c 200)
options=(-H 'Accept-Encoding: gzip')
promise "the player is compressed" head_has cmaf/player.js 'Content-Encoding: gzip'
promise "a segment is not" bash -c "! curl -sI -H 'Accept-Encoding: gzip' 'http://$address/$segment' | grep -i gzip"
options=(-H "If-None-Match: $(curl -sI "http://$address/cmaf/film.m3u8" | sed -n 's/^ETag: //p' | tr -d '\r')")
promise "what is there is not sent again" head_has cmaf/film.m3u8 '304 Not Modified'

# For as long as a test can take; how many segments were late is printed.
promise "a thousand viewers get what they ask for" python3 "$root/tests/pipelines/crowd.py" "$address" /cmaf/film.m3u8 1000 8
