#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Measures how long feeling-wind takes from its start to the first frame of a film, in an X server of its own. The first
# start reads the program from the disk and fills GStreamer's registry; then come nine more.
#
# Usage: tests/measure/benchmarks/first-frame.sh FILM [PROGRAM]
#   PROGRAM  feeling-wind as it is installed by default; build/pipelines/feeling-wind/feeling-wind is that of a build

source "$(dirname "$0")/../../../pipelines/shared/common.sh"

[[ ${1:-} != --help && ${1:-} != -h ]] || { show_help && exit; }
[ -f "${1:-}" ] || fail "there is no film; name one, see --help"
video=$1 feeling_wind=${2:-feeling-wind}
command -v "$feeling_wind" >/dev/null || fail "'$feeling_wind' is not there; install the package, or name a build's program"

if [ -z "${FIRST_FRAME_DISPLAY:-}" ]; then
  command -v xvfb-run >/dev/null || fail "xvfb-run is not installed (packages xvfb and xauth)"
  FIRST_FRAME_DISPLAY=yes exec xvfb-run -a -s '-screen 0 1920x1080x24 -noreset' "$0" "$@"
fi
home=$(mktemp -d)
trap 'rm -rf "$home"' EXIT
export NO_AT_BRIDGE=1 GSETTINGS_BACKEND=memory XDG_CONFIG_HOME=$home XDG_CACHE_HOME=$home

# Prints the milliseconds of one start.
start() {
  local began=$EPOCHREALTIME line process
  exec {lines}< <(exec "$feeling_wind" --verbose "$video" 2>&1)
  process=$!
  while read -r -t 60 -u "$lines" line; do
    [[ $line != *'first frame'* ]] || break
  done
  [[ $line = *'first frame'* ]] || fail "no first frame within 60 s: $line"
  echo $(((${EPOCHREALTIME/./} - ${began/./}) / 1000))
  kill -INT "$process"
  while kill -0 "$process" 2>/dev/null; do sleep 0.05; done
  exec {lines}<&-
}

echo "first start: $(start) ms"
for _ in {1..9}; do start; done | sort -n | awk '
  { ms[NR] = $1 }
  END { print "then: median " ms[int((NR + 1) / 2)] " ms, slowest of " NR " " ms[NR] " ms" }'
