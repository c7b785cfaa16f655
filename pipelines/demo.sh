#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Sets everything up on Debian 12 or 13 and runs the paper's system: a simulated hand moves over a film
# of a tree in the wind, which wind-film draws, and feels it move. Writes to demo-output/
#   trace.csv  one row per millisecond: hand, velocity, force, string tensions
#   trace.png  velocity and force over time, as the paper's figure 11
# and prints a summary. The first run installs Debian packages, which it lists, and builds the plugins;
# later runs take as long as the film, 20 s. Ctrl-C ends it early and keeps the results.
#
# Usage: pipelines/demo.sh [OPTION...]
#   --video FILE          a video of your own instead of the tree
#   --camera /dev/videoN  a camera instead of a file; "--camera test" is a live test video
#   --seconds N           end after N seconds (a camera: 30; a file: at its end)
#   --device DEVICE       sim (default): a simulated SPIDAR-G with a moving hand
#                         usb or usb:ID: a real one; auto: a real one, or else a simulated one
#   --show                show the video in a window, with motion and force drawn over it
#   --output DIR          where the results go (demo-output)
#
# Example:
#   pipelines/demo.sh --video in.mp4 --show

source "$(dirname "$0")/shared/common.sh"
source "$(dirname "$0")/shared/packages.sh"

video='' camera='' seconds='' device=sim show=no output=demo-output
hand=circle:0.6,20 strength=()

check_options() {
  [ -z "$video" ] || [ -z "$camera" ] || fail "give either --video or --camera, not both"
  [ -z "$video" ] || need_input "$video"
  [ -z "$camera" ] || [ "$camera" = test ] || need_camera "$camera"
  [ -z "$camera" ] || seconds=${seconds:-30}
  [[ ${seconds:-1} =~ ^[1-9][0-9]{0,5}$ ]] || fail "--seconds needs a whole number from 1, not '$seconds'"
  [[ $device =~ ^(sim|auto|usb|usb:.+)$ ]] || fail "--device is sim, usb, usb:ID or auto, not '$device'"
  [ "$show" = no ] || may_show || show=no
  make_output "$output"
}

# Installs packages and builds, unless FEELING_WIND_BUILD names a finished build or the script is installed.
set_up() {
  if [ -z "${FEELING_WIND_BUILD:-}" ] && in_checkout; then
    install_packages "${run_packages[@]}" "${build_packages[@]}"
    build_plugins
  fi
  use_elements
  if [ -z "$video$camera" ]; then
    video=$(wind_film)
    hand=file:$root/pipelines/films/hands/wind-hand.csv strength=("alpha=$wind_alpha")
  fi
}

# Sets $line to the gst-launch line.
make_line() {
  if [ "$camera" = test ]; then
    line=("${test_source[@]}" ! "${camera_frames[@]}")
  elif [ -n "$camera" ]; then
    line=(v4l2src "device=$(quoted "$camera")" ! "${camera_frames[@]}")
  else
    line=("${film[@]}")
  fi
  line+=(! progressreport update-freq=1 silent=true ! roitracker !)
  [ "$show" = no ] || line+=("${window_branch[@]}")
  line+=(velocityavg ! hapticsink "device=$(quoted "$device")" "sim-hand=$(quoted "$hand")"
    "${strength[@]}" "log-location=$(quoted "$output/trace.csv")")
}

# `follow LOG` reads a process id and then the output of that gst-launch -m. Writes the output to LOG,
# shows progress and warnings, and interrupts gst-launch after $seconds, if set.
follow() {
  local log=$1 process text rest='' began=$SECONDS interrupted=no starting=30
  trap '' INT # Ctrl-C ends gst-launch; its last output is still read
  read -r process
  while true; do
    if IFS= read -r -t 1 text; then
      text=$rest$text rest=''
      printf '%s\n' "$text" >>"$log"
      show_event "$text"
      # Some window systems need seconds before the first frame.
      [[ $text != 'Setting pipeline to PLAYING'* ]] || began=$SECONDS starting=0
    elif [ $? -gt 128 ]; then
      rest+=$text
    else
      break
    fi
    if [ -n "$seconds" ] && [ $((SECONDS - began)) -ge $((seconds + starting)) ]; then
      if [ $interrupted = no ]; then
        interrupted=yes
        kill -INT "$process" 2>/dev/null || true
      elif [ $((SECONDS - began)) -ge $((seconds + starting + 15)) ]; then
        kill -KILL "$process" 2>/dev/null || true
      fi
    fi
  done
  [ ! -t 1 ] || printf '\r\e[K'
}

show_event() {
  local now total of=''
  case $1 in
  *'(element): progress,'*)
    [[ $1 =~ current=\(gint64\)([0-9]+) ]] || return 0
    now=${BASH_REMATCH[1]}
    total=$seconds
    [[ ! $1 =~ total=\(gint64\)([0-9]+) ]] || total=${BASH_REMATCH[1]}
    [ -z "$total" ] || of=" of $total"
    if [ -t 1 ]; then
      printf '\r\e[K  %s%s s' "$now" "$of"
    elif [ $((now % 5)) = 0 ] && [ "$now" != "${shown:-0}" ]; then
      shown=$now
      printf '  %s%s s\n' "$now" "$of"
    fi
    ;;
  'WARNING: from element '*) printf '\r%s\n' "Note: ${1#*: * }" ;;
  esac
}

# `statistic LOG MESSAGE FIELD` prints a number from the last element message of that name.
statistic() {
  sed -n "s/.*(element): $2, \(.* \)\?$3=([a-z0-9]*)\([^,;]*\).*/\2/p" "$1" | tail -n 1
}

summarise() {
  local log=$1 trace=$output/trace.csv
  tracker() { statistic "$log" roitracker-stats "$1"; }
  loop() { statistic "$log" hapticsink-stats "$1"; }
  echo
  awk -F, -v frames="$(tracker frames)" -v measured="$(tracker measured)" \
    -v still="$(tracker still)" -v repeated="$(tracker duplicates)" -v points="$(tracker points)" \
    -v ticks="$(loop ticks)" -v late="$(loop late-ticks)" -v missed="$(loop missed-ticks)" \
    -v start50="$(loop jitter-p50)" -v start99="$(loop jitter-p99)" -v start="$(loop jitter-max)" \
    -v body50="$(loop loop-p50)" -v body99="$(loop loop-p99)" '
    NR == 1 { for (i = 1; i <= NF; i++) c[$i] = i; next }
    {
      rows++; last = $c["time"]
      speed = sqrt($c["vx"] ^ 2 + $c["vy"] ^ 2); if (speed > fastest) fastest = speed
      force = sqrt($c["fx"] ^ 2 + $c["fy"] ^ 2 + $c["fz"] ^ 2); if (force > strongest) strongest = force
      if (rows == 1) { fx0 = fx1 = $c["fx"]; fy0 = fy1 = $c["fy"] }
      if ($c["fx"] < fx0) fx0 = $c["fx"]; if ($c["fx"] > fx1) fx1 = $c["fx"]
      if ($c["fy"] < fy0) fy0 = $c["fy"]; if ($c["fy"] > fy1) fy1 = $c["fy"]
    }
    END {
      if (frames != "") {
        printf "Frames      %d: %d measured, %d still, %d repeated\n", frames, measured, still, repeated
        printf "Points      %.1f in a measured frame\n", points
      }
      if (rows == 0) { print "The log holds no rows."; exit }
      printf "Velocity    at most %.0f px/s\n", fastest
      printf "Force       x %.2f to %.2f N, y %.2f to %.2f N, at most %.2f N\n", fx0, fx1, fy0, fy1, strongest
      if (ticks != "") {
        printf "1 kHz loop  %d ticks in %.1f s, %d late by more than 1 ms, %d by more than 10 ms\n", ticks, last, late, missed
        printf "            a tick begins %.0f us late (median), %.0f us (99 %%), %.0f us (worst)\n", start50, start99, start
        printf "            and takes %.0f us (median), %.0f us (99 %%)\n", body50, body99
      }
    }' "$trace"
}

run() {
  local log=$output/gst-launch.log status
  : >"$log"
  make_line
  echo "Running, with the log in $log:"
  show_line gst-launch-1.0 -e -m "${line[@]}"
  trap : INT # the summary is still printed
  set +e
  {
    echo "$BASHPID"
    exec "${with_us[@]}" gst-launch-1.0 -e -m "${line[@]}" 2>&1
  } | follow "$log"
  status=${PIPESTATUS[0]}
  set -e
  [ "$status" = 0 ] || fail "${camera:+the camera $camera: }$(reason <"$log") (log: $log)"
  summarise "$log"
  draw_trace "$output" trace.gp "${camera:+camera $camera}${video##*/}"
}

read_options 'video= camera= seconds= device= output= show' "$@"
[ ${#inputs[@]} = 0 ] || fail "unknown option '${inputs[0]}'; see --help"
check_options
set_up
[ -z "$video" ] || need_video "$video"
run
