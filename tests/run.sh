#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Installs missing Debian packages (it prints which), builds, runs the tests, and ends with one line:
# N passed, N failed, N skipped. The exit status is 0 only when nothing failed. Each check of format,
# style or scripts counts as one test. Without an option it takes at most ten minutes on two processors.
#
# Usage: tests/run.sh [--all]
#   --all  every test there is, in at most an hour: also the long ones, the player in a browser, the sanitizers,
#          inputs that coverage guides, the virtual machine, the lab, clang-tidy, the demonstration built from
#          nothing, and the other Debian
#
# Builds in build-tests/, and with --all in build-sanitized/ too.

source "$(dirname "$0")/../pipelines/common.sh"
source "$(dirname "$0")/../pipelines/packages.sh"

all=no
case ${1:-} in
'') ;;
--all) all=yes ;;
--help | -h) show_help && exit ;;
*) fail "unknown option '$1'; see --help" ;;
esac

cd "$root"
unset GST_PLUGIN_PATH GST_PLUGIN_PATH_1_0 GST_REGISTRY GST_REGISTRY_1_0 FEELING_WIND_BUILD
scratch=$(mktemp -d)
results=$scratch/results # the lines that summary.py counts
outputs=$scratch/outputs # what each failed test printed
mkdir "$outputs"
: >"$results"

# `record OUTCOME NAME SECONDS REASON`
record() {
  (IFS=$'\t' && printf '%s\n' "$*") >>"$results"
}

# However the script ends, the closing line is printed, and an early end counts as a failure.
finish() {
  [ "$1" = 0 ] || record failed "tests/run.sh" 0 "it ended early with status $1"
  local status=0
  if command -v python3 >/dev/null; then
    python3 tests/summary.py close "$results" "$outputs" || status=1
  else
    echo "0 passed, 1 failed, 0 skipped"
    status=1
  fi
  rm -rf "$scratch"
  exit "$status"
}
trap 'finish $?' EXIT

step() {
  printf '\n== %s\n' "$*"
}

# `check NAME COMMAND...` runs a command as one test. Exit status 77 means skipped.
check() {
  local name=$1 status=0 start=$SECONDS output
  shift
  output=$(mktemp -p "$scratch")
  step "$name"
  "$@" 2>&1 </dev/null | tee "$output" || status=$?
  case $status in
  0) record passed "$name" $((SECONDS - start)) OK ;;
  77) record skipped "$name" $((SECONDS - start)) "$(sed -nE 's/^SKIP(PED)?: *//p' "$output" | head -n 1)" ;;
  *)
    record failed "$name" $((SECONDS - start)) "exit status $status"
    mv "$output" "$outputs/${name//\//-}"
    ;;
  esac
  return "$status"
}

set_up() {
  step "Packages"
  install_packages "${run_packages[@]}" "${build_packages[@]}" "${view_packages[@]}" \
    "${test_packages[@]}" "${vm_packages[@]}"
  echo "tree.avi: $(tree_video)"
  echo "aloe: $(opencv_file aloeGT.png)"
  [ "$all" = no ] || set_up_web
}

# Without them the tests of the player in a browser and of a packaged film on a server are skipped.
set_up_web() {
  (install_packages "${browser_packages[@]}" && install_npm && pipelines/web/fetch.sh --tests) || true
  (install_packages "${server_packages[@]}") || true
  (install_packages "${engine_packages[@]}") || true
}

# `build_in FOLDER MESON-OPTION...`
build_in() {
  local folder=$1 log=$1/build.log
  shift
  mkdir -p "$folder"
  if [ -f "$folder/build.ninja" ]; then
    set -- --reconfigure "$@"
  fi
  if ! meson setup "$folder" "$@" >"$log" 2>&1 || ! meson compile -C "$folder" >>"$log" 2>&1; then
    # Other commands were still running when one failed: its message is not the last.
    grep -A 30 '^FAILED:' "$log" || tail -n 40 "$log"
    return 1
  fi
}

# The lab and the benchmarks, which only --all needs, are a fifth of the whole build.
build_plain() {
  local lab=disabled
  [ "$all" = no ] || lab=enabled
  build_in build-tests -Dwerror=true -Ddebug=false -Dtests=enabled -Dbenchmarks=$lab \
    -Ddocumentation-uri="file://$root/build-site" -Dvision=enabled -Ddevice=enabled -Dtrack=enabled
}

# Without precompiled headers, which hide a missing #include. Less optimised, which halves the time to compile.
build_sanitized() {
  build_in build-sanitized -Db_sanitize=address,undefined -Db_lundef=false -Db_pch=false \
    -Doptimization=1 -Ddebug=false \
    -Dtests=enabled -Dbenchmarks=disabled -Dvision=enabled -Ddevice=enabled -Dtrack=enabled
}

# With the processor time that the tests leave, most of which wait for real time.
in_idle_time() {
  chrt --idle --pid 0 "$BASHPID" 2>/dev/null || renice -n 19 "$BASHPID" >/dev/null
  "$@"
}

# Cases that repeat for statistics or for hours what others check once, or that only measure time. A sanitizer
# would find nothing more in them.
repetitions=(
  '*.F20_*' '*.F27_*' '*Ticks.AFullTickTakes*' 'OurPart.OfATickTakes*'
  'FastTracker.HoldsUpToSixteenPixels' 'FastTracker.EverySixteenthOfAPixelHasTheSameSmallBias'
  '*TrackerLimits.AfterTheFirst*NothingIsAllocated' 'FastTracker.ChangesOfGainAndOffsetDoNotMoveAnything'
  'PoseSolver.TheOrientationStaysARotation*' 'TensionSolver.AgreesWithBruteForce*'
  'OpencvTracker.AlmostNeverErrsGrosslyUpToSixteenPixels'
  '*MotionModels.TheSmallestThatExplainsTheSceneIsChosen*'
)
# `run_meson_tests PREFIX FOLDER OPTION...` records each test of a build folder. Twice as many at once as there
# are processors, since most wait for real time; the few that failed once more, alone. The time limits are meant for a
# machine with other work.
run_meson_tests() {
  local prefix=$1 folder=$2 log=$2/meson-logs/testlog.json status=0 again=()
  shift 2
  rm -f "${log%.json}"*.json
  set -- meson test -C "$folder" --no-rebuild --print-errorlogs "$@"
  "$@" --num-processes $((2 * $(nproc))) </dev/null || status=$?
  mapfile -t again < <(python3 tests/summary.py failed "$log")
  if [ ${#again[@]} -gt 0 ]; then
    step "Alone: ${again[*]}"
    # Its status is the number of failed tests, if nothing else went wrong.
    "$@" --num-processes 1 --logbase testlog-alone "${again[@]}" </dev/null && status=$((status - ${#again[@]}))
  fi
  python3 tests/summary.py collect "$prefix" "$log" "$outputs" >"$scratch/collected" || status=1
  cat "$scratch/collected" >>"$results"
  # A run that went wrong without a failed test is a failure too.
  if [ "$status" != 0 ] && ! grep -q ^failed "$scratch/collected"; then
    record failed "${prefix}meson test" 0 "exit status $status"
  fi
}

run_plain_tests() {
  step "Tests"
  if [ "$all" = yes ]; then
    run_meson_tests '' build-tests --timeout-multiplier 3
  else
    run_meson_tests '' build-tests --timeout-multiplier 3 --no-suite hil --no-suite long
  fi
}

# Whether LeakSanitizer works here: some containers forbid what it needs.
leaks_can_be_found() {
  ! ASAN_OPTIONS=detect_leaks=1 build-sanitized/tests/unit/unit-common --gtest_filter=nothing 2>&1 |
    grep -q 'LeakSanitizer has encountered a fatal error'
}

run_sanitized_tests() {
  local leaks=1
  step "Tests with sanitizers"
  if ! leaks_can_be_found; then
    leaks=0
    echo "LeakSanitizer does not work here: leaks are not looked for."
  fi
  # The slow unwinder, since Debian's GLib has no frame pointers and a leak must be told from GLib's own.
  # Without intercept_tls_get_addr=0, LeakSanitizer sometimes reads the thread-local memory of a thread at a
  # wrong address and crashes.
  ASAN_OPTIONS=detect_leaks=$leaks:fast_unwind_on_malloc=0:intercept_tls_get_addr=0 \
    LSAN_OPTIONS=suppressions=$root/tests/suppressions/lsan.supp:print_suppressions=0 \
    UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
    GTEST_FILTER="-$(IFS=: && echo "${repetitions[*]}")" \
    run_meson_tests 'sanitized ' build-sanitized --suite unit --suite elements --suite faults --suite usb \
    --suite fuzz --timeout-multiplier 10
}

check_format() {
  find gst-plugins pipelines spidar tests \( -name '*.[ch]pp' -o -name '*.[ch]' \) -print0 |
    xargs -0 clang-format --dry-run --Werror
}

# With the commands of the sanitized build: clang cannot read GCC's precompiled headers. Each file once, also if several
# programs have it.
check_style() {
  mkdir -p build-sanitized/clang-tidy
  python3 -c 'import json, sys
json.dump(list({command["file"]: command for command in json.load(sys.stdin)}.values()), sys.stdout)' \
    <build-sanitized/compile_commands.json >build-sanitized/clang-tidy/compile_commands.json || return 1
  run-clang-tidy -p build-sanitized/clang-tidy -quiet -j "$(nproc)" "$root/(gst-plugins|pipelines|spidar)/" >build-sanitized/clang-tidy.log 2>&1 ||
    { grep -E -A 5 'warning:|error:' build-sanitized/clang-tidy.log; return 1; }
}

check_scripts() {
  find pipelines tests .ci \( -name '*.sh' -o -path .ci/run \) -print0 |
    xargs -0 shellcheck -x -P SCRIPTDIR
}

# In a copy without a build folder; the moving picture of the README too.
check_demonstration() {
  local copy=$scratch/demonstration
  mkdir "$copy"
  tar --exclude='./build*' --exclude=./.git -cf - . | tar -xf - -C "$copy"
  "$copy/pipelines/demo.sh" --output "$copy/demo-output" &&
    "$copy/pipelines/moving-picture.sh" "$copy/moving.webp"
}

# What needs only processor time, beside the tests that wait.
check_in_background() {
  if check "Everything builds with AddressSanitizer and UndefinedBehaviorSanitizer" build_sanitized; then
    check "clang-tidy finds nothing" check_style || true
  fi
  check "It builds on the other Debian" tests/other-debian.sh --part build || true
  check "The image of haptic-track authors a film" tests/container.sh || true
}

sanitized_build_ended() {
  cut -f 2 "$results" | grep -q AddressSanitizer
}

set_up
check "Every script passes shellcheck" check_scripts || true
check "The source is formatted with clang-format" check_format || true
background=
if check "Everything builds without a warning" build_plain; then
  if [ "$all" = yes ]; then
    in_idle_time check_in_background >build-tests/background.log 2>&1 &
    background=$!
  fi
  run_plain_tests
fi
if [ -n "$background" ]; then
  until sanitized_build_ended || ! kill -0 "$background" 2>/dev/null; do
    sleep 1
  done
  if grep -q '^passed.*AddressSanitizer' "$results"; then
    run_sanitized_tests
  fi
fi
if [ "$all" = yes ]; then
  check "No parser fails on damaged tracks that coverage has guided" tests/fuzz/coverage.sh 15s || true
  check "The demonstration runs as a user starts it" check_demonstration || true
fi
if [ -n "$background" ]; then
  wait "$background" || true
  cat build-tests/background.log
  check "Its tests pass on the other Debian" tests/other-debian.sh --part tests || true
fi
