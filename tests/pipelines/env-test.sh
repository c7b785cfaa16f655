#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# `./env COMMAND` runs a command of the build in the user's folder.

source "$(dirname "$0")/support.sh"
unset GST_PLUGIN_PATH GST_PLUGIN_PATH_1_0

cd "$work"
mkdir "a folder"
cd "a folder"
in_env() { "$root/env" "$@"; }
finds_the_elements() { in_env gst-inspect-1.0 --exists --atleast-version=0.1 roitracker; }
stays() { [ "$(in_env pwd)" = "$PWD" ]; }
# shellcheck disable=SC2016 # the command gets the dollars
hands_on_words() { [ "$(in_env printf '%s|' 'two words' '' '$HOME')" = "two words||\$HOME|" ]; }
hands_on_status() {
  local status=0
  in_env sh -c 'exit 7' || status=$?
  [ "$status" = 7 ]
}
# shellcheck disable=SC2016
hands_on_locale() { [ "$(unset LC_ALL && in_env sh -c 'echo "${LC_ALL-none}"')" = none ]; }
# shellcheck disable=SC2016
adds_no_current_folder() { [[ :$(in_env sh -c 'echo "$LD_LIBRARY_PATH:$GST_PLUGIN_PATH"'): != *::* ]]; }
# A process group of its own, which Ctrl-C would reach.
ends_by_its_own_interrupt() {
  local process status=0
  set -m
  in_env sh -c 'trap "exit 3" INT; touch ready; while :; do sleep 0.1; done' >"$work/said" 2>&1 &
  process=$!
  set +m
  until [ -e ready ]; do sleep 0.1; done
  kill -INT -- "-$process"
  wait "$process" || status=$?
  cat "$work/said"
  [ "$status" = 3 ] && [ ! -s "$work/said" ]
}
is_a_shell() { [ "$(echo 'pwd; exit' | SHELL=/bin/sh in_env 2>&1 | grep -cxF "$PWD")" = 1 ]; }
says_what_to_do() {
  ! FEELING_WIND_BUILD=$work/none in_env true 2>"$work/said" && grep -q 'run ./pipelines/demo.sh' "$work/said"
}
says_how_to_complete_the_build() {
  ! in_env haptic-none 2>"$work/said" && grep -q "no command 'haptic-none'.*meson compile -C" "$work/said"
}
# shellcheck disable=SC2016
scripts_find_the_guardian() {
  (unset SPIDAR_GUARDIAN && bash -c 'source "$1/pipelines/shared/common.sh" && find_plugins && [ -x "$SPIDAR_GUARDIAN" ]' \
    - "$root")
}
# How build_plugins calls Meson in the folder $work/some, which holds these files.
meson_calls() {
  local file
  rm -rf "$work/some"
  mkdir -p "$work/some/gst-plugins/vision" "$work/some/meson-private"
  for file; do
    touch "$work/some/$file"
  done
  # shellcheck disable=SC2317 # build_plugins calls it
  (
    meson() { echo "$@" >&3; }
    build=$work/some
    build_plugins >/dev/null
  ) 3>&1
}
configures_what_was_interrupted() {
  [[ $(meson_calls) = "setup $work/some "*-Dvision=enabled* ]] && [ ! -e "$work/some/meson-private" ]
}
completes_what_has_no_vision() { [[ $(meson_calls build.ninja) = "setup --reconfigure $work/some "*-Dvision=enabled* ]]; }
only_compiles_what_is_whole() {
  [ "$(meson_calls build.ninja gst-plugins/vision/libgsthapticvision.so)" = "compile -C $work/some" ]
}
promise "what an interrupted setup left is configured anew" configures_what_was_interrupted
promise "a build of before the packages came is completed" completes_what_has_no_vision
promise "a whole one is compiled, no more" only_compiles_what_is_whole
promise "it finds the elements of the build" finds_the_elements
promise "the scripts find its guardian, too" scripts_find_the_guardian
promise "it finds the tools of the build" in_env spidar-info --help
promise "it stays in the user's folder" stays
promise "the command gets the words that the user wrote" hands_on_words
promise "the status is that of the command" hands_on_status
promise "the command has the locale of the user" hands_on_locale
promise "nothing is looked for in the current folder" adds_no_current_folder
promise "Ctrl-C reaches the command alone" ends_by_its_own_interrupt
promise "alone, it is a shell in the user's folder" is_a_shell
promise "without a build, it says what to do" says_what_to_do
promise "without the command, it says how to complete the build" says_how_to_complete_the_build
