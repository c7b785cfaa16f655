#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Repeats the paper's experiment (section 4): a person watches a video with and without force, in random order,
# points anywhere, and rates three aspects each time on the paper's scale of five steps.
#
# Usage: pipelines/study/haptic-study.sh run [OPTION...] VIDEO... [-- OPTION=VALUE...]
#        pipelines/study/haptic-study.sh report ANSWERS.csv [PLOT.png]
#   run      one session with a random video. Each answer is written at once.
#     --participant NAME  letters, digits, _ and - (anonymous)
#     --answers FILE      file of the answers (answers.csv)
#     --seconds N         play at most N seconds each time
#     --no-window         do not open a window
#     --seed N            seed of the random choices (default: another one each time)
#     What follows -- goes to hapticsink, both times.
#   report   prints the counts and the weighted average value (equation 6) of each aspect with and without force,
#            and draws them as the paper's figure 12
#
# Example:
#   pipelines/study/haptic-study.sh run --participant p1 in.mp4 -- device=usb
#
# The line that it runs:
#
#   gst-launch-1.0 filesrc location=VIDEO ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! clocksync ! roitracker ! tee name=t \
#       t. ! queue max-size-buffers=1 ! videoconvert ! autovideosink \
#       t. ! queue max-size-buffers=1 ! velocityavg ! hapticsink max-force=1     (without force: max-force=0)

source "$(dirname "$0")/../shared/common.sh"

header=session,time,participant,video,round,force,interactivity,sensitivity,reality
scale=(Bad Poor Average Good 'Very good')

# The paper's meaning of each aspect.
questions=(
  'Interactivity: could you interact with the things in the video as you wished?'
  'Sensitivity: did you get a real feeling of the scene?'
  'Reality: did you feel involved in the scene, rather than imagining it?'
)

read_run_options() {
  participant=anonymous answers=answers.csv seconds='' seed='' no_window=no
  read_options 'participant= answers= seconds= seed= no-window --' "$@"
  videos=("${inputs[@]}")
  [ ${#videos[@]} -gt 0 ] || fail "there is no video to ask about; name some, see --help"
  for video in "${videos[@]}"; do
    need_video "$video"
    [[ ${video##*/} != *[,\"]* ]] || fail "the name of '$video' has a comma or a quote, which the answers cannot hold; rename it"
  done
  [[ $participant =~ ^[[:alnum:]_-]+$ ]] || fail "--participant takes letters, digits, _ and -, not '$participant'"
  [[ $seconds =~ ^([1-9][0-9]{0,5})?$ ]] || fail "--seconds needs a whole number from 1, not '$seconds'"
  [[ $seed =~ ^[0-9]{0,9}$ ]] || fail "--seed needs a whole number, not '$seed'"
  [ -z "$seed" ] || RANDOM=$((10#$seed))
  [ "$no_window" = yes ] || need_display
}

prepare_answers() {
  if [ -s "$answers" ]; then
    [ "$(head -n 1 "$answers")" = "$header" ] || fail "'$answers' is not a file of answers; give another with --answers"
    [ -w "$answers" ] || fail "'$answers' may not be written to; give another with --answers"
  else
    echo "$header" 2>/dev/null >"$answers" || fail "'$answers' cannot be written; give another with --answers"
  fi
}

# `play VIDEO MAX-FORCE`. With 0 the grip still points.
play() {
  local line status=0
  decoding "$1"
  line=("${film[@]}" ! clocksync ! roitracker !)
  [ "$no_window" = yes ] || line+=("${file_window_branch[@]}")
  line+=(velocityavg ! hapticsink "${sink_options[@]}" "max-force=$2")
  # Ctrl-C ends the video, not the session.
  trap : INT
  "${with_us[@]}" timeout --foreground --preserve-status -k 20 -s INT "${seconds:-0}" gst-launch-1.0 -q -e "${line[@]}" ||
    status=$?
  trap - INT
  [ "$status" = 0 ] || [ "$status" = 130 ] || fail "'$1' could not be played to its end; try another video (no question was asked about it)"
}

# `ask QUESTION` sets $rating to the answer.
ask() {
  local i
  echo
  echo "$1"
  for i in "${!scale[@]}"; do
    printf '  %d %s' $((i + 1)) "${scale[i]}"
  done
  echo
  while true; do
    read -r -p '1 to 5: ' rating || fail "the session was broken off; start a new one (what was answered before is in '$answers')"
    [[ ! $rating =~ ^[1-5]$ ]] || return 0
    echo "Please type a number from 1 (${scale[0]}) to 5 (${scale[4]})."
  done
}

run_session() {
  local video first session order round ratings question
  use_elements
  prepare_answers
  video=${videos[RANDOM % ${#videos[@]}]}
  session=$(date -u +%Y%m%dT%H%M%S)-$$
  first=$((RANDOM % 2))
  [ "$first" = 1 ] && order=(yes no) || order=(no yes)
  for round in 0 1; do
    echo
    echo "The video is shown for the $([ "$round" = 0 ] && echo first || echo second) time. Point anywhere."
    play "$video" "$([ "${order[round]}" = yes ] && echo 1 || echo 0)"
    ratings=()
    for question in "${questions[@]}"; do
      ask "$question"
      ratings+=("$rating")
    done
    (
      IFS=,
      echo "$session,$(date -u +%FT%TZ),$participant,${video##*/},$((round + 1)),${order[round]},${ratings[*]}"
    ) >>"$answers" || fail "'$answers' cannot be written; give another with --answers"
  done
  echo
  echo "Thank you. The answers are in $answers; see '$0 report $answers'."
}

# `weigh ANSWERS TABLE` prints how many answers there are, and writes to TABLE the count of each answer and the
# weighted average value (equation 6) as CSV.
weigh() {
  awk -F, -v header="$header" -v table="$2" '
    NR == 1 { if ($0 != header) { print "the first line is not \"" header "\"" >"/dev/stderr"; exit bad = 1 }; split($0, aspect); next }
    /^$/ { next }
    {
      good = NF == 9 && $6 ~ /^(yes|no)$/
      for (i = 7; i <= 9; i++) good = good && $i ~ /^[1-5]$/
      if (!good) { print "line " NR " is not an answer: " $0 >"/dev/stderr"; exit bad = 1 }
      for (i = 7; i <= 9; i++) { count[i, $6, $i]++; sum[i, $6] += $i; n[i, $6]++ }
      if (!seen[$1]++) sessions++
      if (!known[$3]++) participants++
      rounds++
    }
    END {
      if (bad) exit 1
      if (!rounds) { print "there are no answers in it" >"/dev/stderr"; exit 1 }
      printf "%d sessions, %d of them broken off, %d participants\n", sessions, 2 * sessions - rounds, participants
      print "aspect,force,n,Bad,Poor,Average,Good,Very good,WAV" >table
      for (i = 7; i <= 9; i++)
        for (k = 1; k <= 2; k++) {
          force = k == 1 ? "yes" : "no"
          if (!n[i, force]) continue
          printf "%s,%s,%d", aspect[i], k == 1 ? "with" : "without", n[i, force] >table
          for (step = 1; step <= 5; step++) printf ",%d", count[i, force, step] >table
          printf ",%.2f\n", sum[i, force] / n[i, force] >table
        }
    }' "$1"
}

report() {
  [ $# -gt 0 ] || fail "there are no answers to report; name their file, see --help"
  [ -f "$1" ] || fail "there is no file '$1'; check the name"
  table=$(mktemp)
  trap 'rm -f "$table"' EXIT
  weigh "$1" "$table" || fail "'$1' cannot be used; give a file that 'haptic-study.sh run' wrote"
  awk -F, '{ printf "%-14s %-8s", $1, $2; for (i = 3; i <= NF; i++) printf " %9s", $i; print "" }' "$table"
  [ $# = 1 ] || gnuplot -c "$root/pipelines/study/haptic-study.gp" "$table" "$2" || fail "gnuplot could not draw '$2'; install gnuplot-nox, or give another name"
}

case ${1:-} in
run) shift && case ${1:-} in --help | -h) show_help && exit ;; esac && read_run_options "$@" && run_session ;;
report) shift && report "$@" ;;
--help | -h) show_help ;;
*) fail "there is no verb; give run or report, see --help" ;;
esac
