# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034,SC2154 # shared with the scripts that source it
# What touch-depth.sh and touch-colour.sh have in common: options, the run, its log and its plot. To be sourced after
# common.sh.

video='' touch=surface+motion output=touch-output no_window=no

# `read_touch_options EXTRA ARGUMENT...` reads the options of both scripts, and EXTRA, which only one of them has.
read_touch_options() {
  read_options "$1 video= touch= output= no-window --" "${@:2}"
  [ ${#inputs[@]} = 0 ] ||
    fail "'${inputs[0]}' is not an option; give a video with --video, and options of hapticsink after --"
  [[ " ${sink_options[*]} " != *' log-location='* ]] || fail "the log is in the folder that --output names; leave log-location= out"
  [[ $touch =~ ^(off|surface|surface\+motion)$ ]] || fail "--touch is surface+motion, surface or off, not '$touch'"
}

# Sets $window to the part of the line between roitracker and velocityavg, and $to_hand to the way of the surface. In a
# window the height is shown as light, and the picture yields under the hand.
choose_window() {
  window=() to_hand=(hand.relief)
  [ "$no_window" = no ] && may_show || return 0
  window=(tee name=t t. ! queue max-size-buffers=1 ! videoconvert ! hapticoverlay name=seen deform=4 ! videoconvert
    ! autovideosink t. ! queue max-size-buffers=1 !)
  to_hand=(tee name=surface surface. ! queue ! seen.relief surface. ! queue ! hand.relief)
}

# `feel OPTION=VALUE...` sets $felt to the part of the line from roitracker on; $to_hand takes the surface there.
feel() {
  felt=(roitracker ! "${window[@]}" velocityavg ! hapticsink name=hand "touch=$touch"
    "log-location=$(quoted "$output/trace.csv")" "$@" "${sink_options[@]}")
}

# `play TITLE LINE...` runs gst-launch, then prints and draws what was felt. Ctrl-C ends the film and keeps the results.
play() {
  local title=$1 log=$output/gst-launch.log status=0
  shift
  show_line gst-launch-1.0 -e "$@"
  trap : INT
  "${with_us[@]}" gst-launch-1.0 -e "$@" 2>&1 | tee -i "$log" || status=$?
  [ "$status" = 0 ] || fail "$(reason <"$log") (log: $log)"
  summarise_touch
  draw_trace "$output" touch.gp "$title"
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
