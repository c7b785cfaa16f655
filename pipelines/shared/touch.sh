# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034,SC2154 # shared with the scripts that source it
# What touch-depth.sh and touch-colour.sh have in common: options, the run, its log and its plot. To be sourced after
# common.sh.

video='' touch=surface+motion output=touch-output shows=auto sink_options=()

# `read_touch_options EXTRA ARGUMENT...` reads the options of both scripts, and EXTRA, which only one of them has: a
# word with = sets the variable of that name to its value, without = to yes.
read_touch_options() {
  local extra=$1 name
  shift
  while [ $# -gt 0 ]; do
    name=${1#--}
    case $1 in
    --help | -h)
      show_help
      exit
      ;;
    --)
      shift
      sink_options=("$@")
      break
      ;;
    --no-window) shows=no ;;
    --video | --touch | --output | "--${extra%=}")
      if [ "$name" = "$extra" ]; then
        printf -v "$name" yes
      else
        [ -n "${2:-}" ] || fail "$1 needs a value; see --help"
        printf -v "$name" %s "$2"
        shift
      fi
      ;;
    -*) fail "unknown option '$1'; see --help" ;;
    *) fail "what is '$1'? Give a video with --video, and options of hapticsink after --" ;;
    esac
    shift
  done
  [[ $touch =~ ^(off|surface|surface\+motion)$ ]] || fail "--touch is surface+motion, surface or off, not '$touch'"
}

# Sets $window to the part of the line between roitracker and velocityavg, and $to_hand to the way of the surface. In a
# window the height is shown as light, and the picture yields under the hand.
choose_window() {
  window=() to_hand=(hand.relief)
  if [ "$shows" = auto ]; then
    shows=yes
    has_display || { echo "There is no display: continuing without a window." && shows=no; }
  fi
  [ "$shows" = yes ] || return 0
  window=(tee name=t t. ! queue max-size-buffers=1 ! videoconvert ! hapticoverlay name=seen deform=4 ! videoconvert
    ! autovideosink t. ! queue max-size-buffers=1 !)
  to_hand=(tee name=surface surface. ! queue ! seen.relief surface. ! queue ! hand.relief)
}

# `feel OPTION=VALUE...` sets $felt to the part of the line from roitracker on; $to_hand takes the surface there.
feel() {
  felt=(roitracker ! "${window[@]}" velocityavg ! hapticsink name=hand "touch=$touch"
    "log-location=$(quoted "$output/trace.csv")" "$@" "${sink_options[@]}")
}

make_output() {
  if ! mkdir -p "$output" 2>/dev/null || ! : 2>/dev/null >"$output/trace.csv"; then
    fail "the folder '$output' cannot be written to; give another with --output"
  fi
}

# `play TITLE LINE...` runs gst-launch, then prints and draws what was felt. Ctrl-C ends the film and keeps the results.
play() {
  local title=$1 log=$output/gst-launch.log status=0
  shift
  show_line gst-launch-1.0 -e "$@"
  trap : INT
  gst-launch-1.0 -e "$@" 2>&1 | tee -i "$log" || status=$?
  [ "$status" = 0 ] || fail "$(reason <"$log") (log: $log)"
  summarise_touch
  draw_touch "$title"
}

summarise_touch() {
  awk -F, '
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    {
      rows++; touched += $at["touch"]
      if ($at["fz"] > push) push = $at["fz"]
      force = sqrt($at["fx"] ^ 2 + $at["fy"] ^ 2 + $at["fz"] ^ 2); if (force > strongest) strongest = force
    }
    END {
      if (rows) printf "Touched     %.0f %% of %.1f s\nForce       %.2f N towards the user at most, %.2f N in all\n",
        100 * touched / rows, rows / 1000, push, strongest
    }' "$output/trace.csv"
}

draw_touch() {
  if [ "$(wc -l <"$output/trace.csv")" -lt 3 ]; then
    rm -f "$output/trace.png"
    echo "Files       $output/trace.csv (too short for a plot)"
    return
  fi
  gnuplot -c "$root/pipelines/shared/touch.gp" "$output/trace.csv" "$output/trace.png" "$1" ||
    fail "gnuplot could not draw $output/trace.png; install gnuplot-nox"
  echo "Files       $output/trace.csv, $output/trace.png"
}
