#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Installs what is missing on a Debian 12 (it says what), builds, runs every test and check, and
# closes with one line: N passed, N failed, N skipped. The exit status is 0 only when nothing
# failed. Each check of format, style or scripts counts as one test.
#
# Usage: tests/run.sh [--quick | --all]
#   --quick  without the sanitizers
#   --all    with clang-tidy and a build of the demonstration from nothing, which takes ten minutes more
#
# Builds in build-tests/ and build-sanitized/, the demonstration of --all in build/.

source "$(dirname "$0")/../pipelines/common.sh"
source "$(dirname "$0")/../pipelines/packages.sh"

quick=no all=no
case ${1:-} in
'') ;;
--quick) quick=yes ;;
--all) all=yes ;;
--help | -h) show_help && exit ;;
*) fail "unknown option '$1'; see --help" ;;
esac

cd "$root"
unset GST_PLUGIN_PATH GST_PLUGIN_PATH_1_0 GST_REGISTRY GST_REGISTRY_1_0 FEELING_WIND_BUILD
passed=0 failed=0 skipped=0

# However the script ends, the closing line is printed, and an early end counts as a failure.
finish() {
  [ "$1" = 0 ] || [ "$failed" -gt 0 ] || failed=1
  echo
  echo "$passed passed, $failed failed, $skipped skipped"
  [ "$failed" = 0 ] || exit 1
}
trap 'finish $?' EXIT

step() {
  printf '\n== %s\n' "$*"
}

# Runs a command as one test.
check() {
  local name=$1
  shift
  step "$name"
  if "$@"; then
    echo "ok: $name"
    passed=$((passed + 1))
  else
    echo "FAILED: $name"
    failed=$((failed + 1))
    return 1
  fi
}

set_up() {
  step "Packages"
  install_packages "${run_packages[@]}" "${build_packages[@]}" "${view_packages[@]}" \
    "${test_packages[@]}" "${vm_packages[@]}"
  echo "tree.avi: $(tree_video)"
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
    tail -n 40 "$log"
    return 1
  fi
}

build_sanitized() {
  build_in build-sanitized -Db_sanitize=address,undefined -Db_lundef=false \
    -Doptimization=1 -Ddebug=false `# half the time to compile` \
    -Dtests=enabled -Dbenchmarks=disabled -Dvision=enabled -Ddevice=enabled -Dtrack=enabled
}

# With what the processors have left beside the tests, most of which wait for real time.
in_idle_time() {
  chrt --idle --pid 0 "$BASHPID" 2>/dev/null || renice -n 19 "$BASHPID" >/dev/null
  "$@"
}

# `run_meson_tests FOLDER OPTION...` adds up what meson counted. What failed among the tests that play in real time runs
# once more, alone, without a build beside it: on a shared processor a picture may come too late to be felt in full.
# A wrong force is wrong again.
run_meson_tests() {
  local folder=$1 report=$1/test-report.txt before=$failed status=0 again
  shift
  meson test -C "$folder" --no-rebuild --print-errorlogs "$@" 2>&1 | tee "$report" || status=1
  add_up "$report"
  mapfile -t again < <(sed -nE \
    's|^ *[0-9]+/[0-9]+ feeling-wind:(elements\|faults\|usb\|pipelines\|docs) / ([^ ]+) +(FAIL\|TIMEOUT).*|\2|p' "$report" | sort -u)
  if [ ${#again[@]} -gt 0 ]; then
    while [ -n "${sanitized:-}" ] && kill -0 "$sanitized" 2>/dev/null; do sleep 1; done # what builds meanwhile
    step "Once more, alone: ${again[*]}"
    meson test -C "$folder" --no-rebuild --print-errorlogs --num-processes 1 "$@" "${again[@]}" 2>&1 | tee "$report" ||
      true
    failed=$((failed - ${#again[@]}))
    add_up "$report"
    [ "$failed" -gt "$before" ] || status=0
  fi
  # A run that went wrong without a count of failures still is one.
  [ "$status" = 0 ] || [ "$failed" -gt "$before" ] || failed=$((failed + 1))
}

add_up() {
  passed=$((passed + $(reported "$1" Ok) + $(reported "$1" 'Expected Fail')))
  skipped=$((skipped + $(reported "$1" Skipped)))
  failed=$((failed + $(reported "$1" Fail) + $(reported "$1" 'Unexpected Pass') + $(reported "$1" Timeout)))
}

reported() {
  local number
  number=$(sed -n "s/^$2: *\([0-9]\+\).*/\1/p" "$1" | tail -n 1)
  echo "${number:-0}"
}

# Whether LeakSanitizer works here: some containers forbid what it needs.
leaks_can_be_found() {
  ! ASAN_OPTIONS=detect_leaks=1 build-sanitized/tests/unit/unit-common --gtest_filter=nothing 2>&1 |
    grep -q 'LeakSanitizer has encountered a fatal error'
}

# They repeat for statistics or for hours what others do once, or only measure time: nothing more for a
# sanitizer to see.
statistics=(
  '*.F20_*' '*.F27_*' '*Ticks.AFullTickTakes*' 'OurPart.OfATickTakes*'
  'FastTracker.HoldsUpToSixteenPixels' 'FastTracker.EverySixteenthOfAPixelHasTheSameSmallBias'
  '*TrackerLimits.AfterTheFirstPicturesNothingIsAllocated' 'FastTracker.ChangesOfGainAndOffsetDoNotMoveAnything'
  'PoseSolver.TheOrientationStaysARotation*' 'TensionSolver.AgreesWithBruteForce*'
  'OpencvTracker.AlmostNeverErrsGrosslyUpToSixteenPixels'
  '*MotionModels.TheSmallestThatExplainsTheSceneIsChosen*'
)

run_sanitized_tests() {
  local leaks=1
  if ! leaks_can_be_found; then
    leaks=0
    echo "LeakSanitizer does not work here: leaks are not looked for."
  fi
  # The slow unwinder, since Debian's GLib has no frame pointers and a leak must be told from GLib's own.
  ASAN_OPTIONS=detect_leaks=$leaks:fast_unwind_on_malloc=0 \
    LSAN_OPTIONS=suppressions=$root/tests/suppressions/lsan.supp:print_suppressions=0 \
    UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
    GTEST_FILTER="-$(IFS=: && echo "${statistics[*]}")" \
    run_meson_tests build-sanitized --suite unit --suite elements --suite faults --suite usb --suite fuzz \
    --timeout-multiplier 4
}

check_format() {
  find gst-plugins spidar tests \( -name '*.[ch]pp' -o -name '*.[ch]' \) -print0 |
    xargs -0 clang-format --dry-run --Werror
}

check_style() {
  run-clang-tidy -p build-tests -quiet -j "$(nproc)" "$root/(gst-plugins|spidar)/" \
    >build-tests/clang-tidy.log 2>&1 ||
    { grep -E -A 5 'warning:|error:' build-tests/clang-tidy.log; return 1; }
}

check_scripts() {
  find pipelines tests .ci \( -name '*.sh' -o -path .ci/run \) -print0 |
    xargs -0 shellcheck -x -P SCRIPTDIR
}

set_up
check "Every script passes shellcheck" check_scripts || true
check "The source is formatted with clang-format" check_format || true

if check "Everything builds without a warning" \
  build_in build-tests -Dwerror=true -Ddebug=false -Dtests=enabled -Dbenchmarks=enabled \
  -Dvision=enabled -Ddevice=enabled -Dtrack=enabled; then
  if [ "$quick" = no ]; then
    in_idle_time build_sanitized >build-tests/sanitized.log 2>&1 &
    sanitized=$!
  fi
  step "Unit, element, pipeline and documentation tests"
  run_meson_tests build-tests
  if [ "$all" = yes ]; then
    check "clang-tidy finds nothing" check_style || true
  fi
  if [ "$quick" = no ]; then
    if check "Everything builds with AddressSanitizer and UndefinedBehaviorSanitizer" wait "$sanitized"; then
      step "Unit, element, USB, fault and fuzz tests with sanitizers"
      run_sanitized_tests
    else
      cat build-tests/sanitized.log
    fi
  fi
fi
if [ "$all" = yes ]; then
  check "The demonstration runs as a user starts it" \
    pipelines/demo.sh --output build-tests/demo-output || true
fi
