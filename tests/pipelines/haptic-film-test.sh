#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# haptic-film is the installed command over the scripts: it runs them from a folder of the system, with installed elements
# and tools, and writes only into the folder of the user and the cache.

source "$(dirname "$0")/support.sh"

# The installation: its scripts as Meson installs them; its elements and tools are those of the build.
installed() { DESTDIR=$work/system meson install -C "$build" --no-rebuild --tags scripts >"$work/said" 2>&1 || { cat "$work/said"; return 1; }; }
promise "the scripts are installed" installed
program=$(find "$work/system" -path '*/bin/haptic-film')
tools=$build/pipelines/films:$build/gst-plugins/track/tools
chmod -R a-w "$work/system" # of root, who may write nevertheless
before=$(find "$work/system" | sort)
mkdir "$work/home" "$work/here"
cd "$work/here"
film() {
  env -u FEELING_WIND_BUILD "PATH=$tools:$PATH" "HOME=$work/home" XDG_CACHE_HOME= "$program" "$@" >"$work/said" 2>&1 ||
    { tail -n 20 "$work/said"; return 1; }
}
says() { ! film "${@:2}" >/dev/null && grep -q -- "$1" "$work/said"; }

promise "alone it lists its verbs" film
promise "each verb is listed" test "$(grep -cE '^  (demo|play|camera|record|send|receive|touch|study) ' "$work/said")" = 9
for verb in demo play camera record send receive 'touch colour' 'touch depth' study; do
  # shellcheck disable=SC2086 # two words
  promise "$verb explains itself" film $verb --help
  promise "$verb shows its usage" grep -q '^Usage: ' "$work/said"
done
promise "an unknown verb says what to do" says 'see haptic-film --help' paint
promise "touch says what it needs" says 'touch needs colour or depth' touch

clip film.mkv 352 288 30 1 uniform:40,-20
promise "a file is felt" film play film.mkv -- device=sim log-location=play.csv
promise "its log is in the folder of the user" test -s play.csv
promise "a video is recorded with its track" film record film.mkv recorded.ts -- device=sim
promise "the recording has both" haptic_track info recorded.ts
promise "colours are touched" film touch colour --video film.mkv --no-window -- device=sim
promise "the demonstration runs" film demo --video film.mkv
promise "it draws its plot in the folder of the user" test -s demo-output/trace.png
promise "nothing was built or written into the system" test "$before" = "$(find "$work/system" | sort)"
