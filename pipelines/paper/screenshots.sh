#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Takes the pictures of the program and of the web page: each is a WebP, 960 px wide at most.
#
#   program-empty.webp    the window before anything is opened
#   program.webp          it plays the film of the demonstration, and the mouse points at leaves
#   program-dark.webp     the same with a dark theme
#   page.webp             the page that haptic-track package makes, on a desktop
#   page-phone.webp       the same on a telephone
#
# The program runs in an X server of its own, the page in Chromium. Packages: xvfb xauth xdotool ffmpeg chromium.
#
# Usage: pipelines/paper/screenshots.sh FOLDER

source "$(dirname "$0")/../shared/common.sh"
source "$(dirname "$0")/../shared/packages.sh"

case ${1:---help} in
--help | -h) show_help && exit ;;
-*) fail "unknown option '$1'; see --help" ;;
esac

# Inside the X server: `screenshots.sh FOLDER OUTPUT SECONDS ARGUMENT...`
if [ $# -gt 1 ]; then
  program=$build/pipelines/feeling-wind/feeling-wind
  "$program" --sink "alpha=$wind_alpha" "${@:4}" >/dev/null 2>&1 &
  trap 'kill $! 2>/dev/null || true' EXIT
  window=$(timeout 60 xdotool search --sync --onlyvisible --class feeling-wind | tail -n 1)
  xdotool windowfocus "$window"
  # The window takes the size of the film as soon as it plays. The mouse trembles on leaves that a gust moves.
  for ((step = 0; step < 10 * $3; step++)); do
    eval "$(xdotool getwindowgeometry --shell "$window")" # X, Y, WIDTH, HEIGHT
    xdotool mousemove $((X + 168 + step % 2)) $((Y + 305))
    sleep 0.1
  done
  gst-launch-1.0 -q ximagesrc num-buffers=1 use-damage=false show-pointer=false "startx=$X" "starty=$Y" \
    "endx=$((X + WIDTH - 1))" "endy=$((Y + HEIGHT - 1))" ! videoconvert ! pngenc ! filesink "location=$2.png"
  exit
fi

folder=$1
[ -d "$folder" ] || fail "there is no folder '$folder'; make it, or give another"
for program in xvfb-run xdotool ffmpeg chromium python3; do
  command -v $program >/dev/null || fail "$program is not installed; as root run: apt-get install xvfb xauth xdotool ffmpeg chromium"
done
use_elements roitracker hapticoverlay hapticsink
[ -x "$build/pipelines/feeling-wind/feeling-wind" ] || fail "the program is not built; run ./pipelines/view.sh, which builds it"
video=$(wind_film)
work=$(mktemp -d)
trap 'kill ${server:-} 2>/dev/null || true; rm -rf "$work"' EXIT

export GDK_BACKEND=x11 HOME=$work XDG_CONFIG_HOME=$work XDG_CACHE_HOME=$work # settings of a new user
# `window NAME THEME SECONDS ARGUMENT...`
window() {
  GTK_THEME=$2 xvfb-run -a -s '-screen 0 1280x1024x24 -noreset' "$0" "$folder" "$work/$1" "${@:3}"
  picture "$1"
}
picture() {
  ffmpeg -v error -y -i "$work/$1.png" -vf "scale='min(960,iw)':-2" -c:v libwebp -quality 70 "$folder/$1.webp" </dev/null
}
window program-empty Adwaita 2
window program Adwaita 3 "$video"
window program-dark Adwaita:dark 3 "$video"

[ ! -d "$build/pipelines/web" ] || export FEELING_WIND_WEB=$build/pipelines/web
haptic_track package --output "$work/film" "$video" >/dev/null
python3 -u -m http.server --bind 127.0.0.1 --directory "$work/film" 0 >"$work/served" 2>&1 &
server=$!
until port=$(sed -n 's/.* port \([0-9]*\) .*/\1/p' "$work/served") && [ -n "$port" ]; do sleep 0.1; done
# `page NAME WIDTH,HEIGHT`
page() {
  chromium --headless=new --no-sandbox --disable-gpu --hide-scrollbars "--user-data-dir=$work/$1" "--window-size=$2" \
    --virtual-time-budget=6000 "--screenshot=$work/$1.png" "http://127.0.0.1:$port/" >/dev/null 2>&1
  picture "$1"
}
page page 960,760
page page-phone 500,900
ls "$folder"/{program-empty,program,program-dark,page,page-phone}.webp
