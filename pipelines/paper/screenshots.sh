#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Takes the pictures of windows and of the web page: each is a WebP, 960 px wide at most.
#
#   program-empty.webp       the window before anything is opened
#   program.webp             it plays the film of the demonstration, and the mouse points at leaves
#   program-dark.webp        the same with a dark theme
#   program-fullscreen.webp  the same in full screen
#   program-array.webp       the same with an array of actuators in the corner
#   touch-depth.webp         the window of touch-depth.sh: the hand presses on a ball
#   touch-colour.webp        the window of touch-colour.sh: the hand strokes leaves
#   page.webp                the page that haptic-track package makes, before it plays
#   page-playing.webp        it plays, and the mouse points at leaves
#   page-hold.webp           the mouse holds a tuft of leaves
#   page-phone.webp          the page on a telephone, with a finger on leaves
#
# The programs run in an X server of their own, the page in Chromium. Packages: xvfb xauth xdotool openbox ffmpeg
# chromium nodejs. `pipelines/web/fetch.sh --tests` fetches what drives Chromium.
#
# Usage: pipelines/paper/screenshots.sh FOLDER
#   FOLDER  where the pictures go, for example docs/images/screens

source "$(dirname "$0")/../shared/common.sh"
source "$(dirname "$0")/../shared/packages.sh"

case ${1:---help} in
--help | -h) show_help && exit ;;
--inside) ;;
-*) fail "unknown option '$1'; see --help" ;;
esac

# Inside the X server: `screenshots.sh --inside FILE SECONDS KEY COMMAND...`
if [ "$1" = --inside ]; then
  # Full screen needs a window manager.
  [ -z "$4" ] || { openbox >/dev/null 2>&1 & }
  "${@:5}" >/dev/null 2>&1 &
  program=$!
  trap 'kill $program 2>/dev/null || true' EXIT
  window=$(timeout 60 xdotool search --sync --onlyvisible --class 'feeling-wind|GStreamer' | tail -n 1)
  xdotool windowfocus "$window"
  [ -z "$4" ] || xdotool key "$4"
  # The window takes the size of the film as soon as it plays. The mouse trembles on leaves that a gust moves.
  end=$(date -d "now + $3 seconds" +%s%N)
  for ((step = 0; $(date +%s%N) < end; step++)); do
    eval "$(xdotool getwindowgeometry --shell "$window")" # X, Y, WIDTH, HEIGHT
    xdotool mousemove $((X + 168 + step % 2)) $((Y + 305))
    sleep 0.1
  done
  gst-launch-1.0 -q ximagesrc num-buffers=1 use-damage=false show-pointer=false "startx=$X" "starty=$Y" \
    "endx=$((X + WIDTH - 1))" "endy=$((Y + HEIGHT - 1))" ! videoconvert ! pngenc ! filesink "location=$2"
  exit
fi

folder=$1
[ -d "$folder" ] || fail "there is no folder '$folder'; make it, or give another"
for program in xvfb-run xdotool openbox ffmpeg chromium node python3; do
  command -v $program >/dev/null ||
    fail "$program is not installed; as root run: apt-get install xvfb xauth xdotool openbox ffmpeg chromium nodejs"
done
[ -d "$root/build-web/node_modules/puppeteer-core" ] ||
  fail "what drives Chromium is not there; run ./pipelines/web/fetch.sh --tests"
use_elements roitracker hapticoverlay hapticsink
feeling_wind=$build/pipelines/feeling-wind/feeling-wind
[ -x "$feeling_wind" ] || fail "the program is not built; run ./pipelines/view.sh, which builds it"
video=$(wind_film)
depth_film >/dev/null
work=$(mktemp -d)
trap 'kill ${server:-} 2>/dev/null || true; rm -rf "$work"' EXIT

# The settings of a new user. The scripts find the films of this one.
export GDK_BACKEND=x11 XDG_CONFIG_HOME=$work XDG_CACHE_HOME=$work
# `window NAME SCREEN SECONDS KEY COMMAND...`; SECONDS after the window is there it is taken.
window() {
  xvfb-run -a -s "-screen 0 $2x24 -noreset" "$0" --inside "$work/$1.png" "${@:3}"
  picture "$1"
}
picture() {
  ffmpeg -v error -y -i "$work/$1.png" -vf "scale='min(960,iw)':-2" -c:v libwebp -quality 60 \
    "$folder/$1.webp" </dev/null
}
program=("$feeling_wind" --sink "alpha=$wind_alpha")
export GTK_THEME=Adwaita
window program-empty 1280x1024 2 '' "${program[@]}"
window program 1280x1024 4 '' "${program[@]}" "$video"
GTK_THEME=Adwaita:dark window program-dark 1280x1024 4 '' "${program[@]}" "$video"
window program-fullscreen 960x600 4 F11 "${program[@]}" "$video"
window program-array 1280x1024 4 '' "${program[@]}" --array back-3x4 --array-sink 'fakesink sync=true' "$video"
window touch-depth 1280x1024 4.7 '' "$root/pipelines/touch-depth.sh" --output "$work/touch"
window touch-colour 1280x1024 4 '' "$root/pipelines/touch-colour.sh" --output "$work/touch"

[ ! -d "$build/pipelines/web" ] || export FEELING_WIND_WEB=$build/pipelines/web
haptic_track package --output "$work/film" "$video" >/dev/null
python3 -u -m http.server --bind 127.0.0.1 --directory "$work/film" 0 >"$work/served" 2>&1 &
server=$!
until port=$(sed -n 's/.* port \([0-9]*\) .*/\1/p' "$work/served") && [ -n "$port" ]; do sleep 0.1; done
HOME=$work node "$root/pipelines/paper/page-pictures.mjs" "$(command -v chromium)" "$root/build-web" \
  "http://127.0.0.1:$port/" "$work"
for name in page page-playing page-hold page-phone; do picture $name; done
ls "$folder"/{program-{empty,dark,fullscreen,array},program,touch-{depth,colour},page{,-playing,-hold,-phone}}.webp
