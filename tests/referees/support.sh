# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034,SC2154 # $root is common.sh's, $targets the script's, $failed for it
# Functions of the scripts in this folder. To be sourced after common.sh, not run.

source "$(dirname "${BASH_SOURCE[0]}")/../support/promise.sh"

no_options() {
  case ${1:-} in
  '') ;;
  --help | -h) show_help && exit ;;
  *) fail "unknown option '$1'; see --help" ;;
  esac
}

# `build_failed LOG` shows the first commands that failed: others may have ended after them.
build_failed() {
  grep -A 30 '^FAILED:' "$1" || tail -n 30 "$1"
  fail "it does not build; read the log $1"
}

# `build_sanitized FOLDER MESON-OPTION...` builds $targets, of what needs neither OpenCV nor GTK.
build_sanitized() {
  local folder=$1 log=$1/build.log
  mkdir -p "$folder"
  forget_interrupted_setup "$folder"
  [ -f "$folder/build.ninja" ] ||
    meson setup "$folder" "$root" -Db_lundef=false -Dunity=on -Dunity_size=6 -Doptimization=1 \
      -Ddebug=false -Dtests=enabled -Ddevice=enabled -Dvision=disabled -Dtrack=disabled -Dview=disabled \
      -Dbenchmarks=disabled -Dman-pages=disabled \
      "${@:2}" >"$log" 2>&1 || build_failed "$log"
  ninja -C "$folder" "${targets[@]}" >"$log" 2>&1 || build_failed "$log"
}

# `judge COMMAND...` runs a program. If it fails, $failed becomes yes and the first report of the sanitizer is shown.
failed=no
judge() {
  local status=0 output report='(ERROR|WARNING|FATAL): [A-Za-z]*Sanitizer'
  output=$(mktemp)
  echo "-- $*"
  "$@" >"$output" 2>&1 || status=$?
  case $status in
  0) ;;
  77) sed -nE 's/^SKIP(PED)?: */   not run: /p' "$output" | head -n 1 ;;
  *)
    failed=yes
    if grep -qE "$report" "$output"; then
      grep -A 40 -m 1 -E "$report" "$output" | sed '/^SUMMARY/q'
    else
      tail -n 30 "$output"
    fi
    ;;
  esac
  rm -f "$output"
}

# `cases_of NAME...` prints a filter for GoogleTest: the cases of the unit tests NAME-test.cpp.
cases_of() {
  local name file suites suite patterns=()
  for name in "$@"; do
    file=$(find "$root/tests/unit" -name "$name-test.cpp")
    [ -n "$file" ] || fail "'$name' is no unit test"
    suites=$(sed -nE 's/^(TYPED_)?TEST(_F|_P)?\(([A-Za-z0-9]+),.*/\3/p' "$file" | sort -u)
    [ -n "$suites" ] || fail "$file has no cases"
    for suite in $suites; do
      patterns+=("$suite.*" "$suite/*" "*/$suite.*")
    done
  done
  (IFS=: && echo "${patterns[*]}")
}

# The unit tests of the vector code. Without statistics over many scenes, and frames without an allocation: an emulator
# would find nothing more in them.
vector_tests=(
  image-kernels lk-kernels luma-crop kept-luma pixel-votes pixel-motions velocity-estimate motion-models
  fast-tracker-limits field-tracker-limits
)
vector_repetitions='*.TheSmallestThatExplains*:*.TheFirstFrameAlone*:*.AStationaryMixture*:MotionConfidence.*'
vector_repetitions+=':*.AfterTheFirst*NothingIsAllocated'
