#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Installs missing Debian packages (it prints which), builds, runs the tests, and ends with one line:
# N passed, N failed, N skipped. The exit status is 0 only when nothing failed. Each check of format,
# style or scripts counts as one test.
#
# Usage: tests/run.sh [--gate | --all]
#           what a user runs: 8 minutes on two processors once the packages are installed
#   --gate  what every change passes, 20 minutes: also the tests in real time, of pages and of damaged tracks, the
#           sanitizers, the player in node, shellcheck, clang-format, and clang-tidy on the files that differ from the
#           commit $FEELING_WIND_BASE, or else from the last tag
#   --all   everything, an hour if a compiler cache has seen it, else two: also the long tests, the player in a
#           browser, other sanitizers, instruction sets and options, inputs that coverage guides, the whole range of
#           hands, the virtual machine, the lab, clang-tidy on every file, the demonstration built from nothing, the
#           Debian packages, the container and the other Debian
#
# Builds in build-tests/, build-sanitized/ and build-style/. A compiler cache is used if ccache is installed.

source "$(dirname "$0")/../pipelines/shared/common.sh"
source "$(dirname "$0")/packages.sh"
source "$(dirname "$0")/support/repeat.sh"
source "$(dirname "$0")/support/repetitions.sh"

size=quick
case ${1:-} in
'') ;;
--gate) size=gate ;;
--all) size=all ;;
--help | -h) show_help && exit ;;
*) fail "unknown option '$1'; see --help" ;;
esac

cd "$root"
unset GST_PLUGIN_PATH GST_PLUGIN_PATH_1_0 GST_REGISTRY GST_REGISTRY_1_0 FEELING_WIND_BUILD
# A checkout has new files of known content. Joined sources name each other by absolute paths.
export CCACHE_SLOPPINESS=${CCACHE_SLOPPINESS-include_file_ctime,include_file_mtime,time_macros}
export CCACHE_BASEDIR=${CCACHE_BASEDIR-$root}
scratch=$(mktemp -d)
results=$scratch/results # the lines that summary.py counts
outputs=$scratch/outputs # what each failed test printed
mkdir "$outputs"
: >"$results"
background= # a process group

# `record OUTCOME NAME SECONDS REASON`
record() {
  (IFS=$'\t' && printf '%s\n' "$*") >>"$results"
}

end_background() {
  [ -n "$background" ] || return 0
  kill -- "-$background" 2>/dev/null || true
  wait "$background" 2>/dev/null || true
  # A compiler's half written file is removed first.
  while kill -0 -- "-$background" 2>/dev/null; do sleep 0.1; done
  background=
}

# However the script ends, the closing line is printed, and an early end counts as a failure.
finish() {
  trap - EXIT
  [ "$1" = 0 ] || record failed "tests/run.sh" 0 "it ended early with status $1"
  end_background
  local status=0
  if command -v python3 >/dev/null; then
    python3 tests/summary.py close "$size" "$results" "$outputs" || status=1
  else
    echo "0 passed, 1 failed, 0 skipped"
    status=1
  fi
  rm -rf "$scratch"
  exit "$status"
}
trap 'finish $?' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

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
  install_packages "${run_packages[@]}" "${build_packages[@]}" "${view_packages[@]}" "${test_packages[@]}"
  echo "tree.avi: $(tree_video)"
  echo "aloe: $(opencv_file aloeGT.png)"
  [ "$size" = quick ] || (install_packages "${clang_packages[@]}") || install_packages clang-tidy
  [ "$size" = all ] || return 0
  # The tests that need these are skipped without them.
  (install_packages ccache) || true # options.sh compiles again what build-tests/ has
  (install_packages "${vm_packages[@]}") || true
  (install_packages "${browser_packages[@]}" && install_npm && pipelines/web/fetch.sh --tests) || true
  (install_packages "${server_packages[@]}") || true
  (install_packages "${engine_packages[@]}") || true
  (install_packages "${referee_packages[@]}") || true
}

# `configure FOLDER MESON-OPTION...`
configure() {
  local folder=$1 again=()
  shift
  forget_interrupted_setup "$folder"
  [ ! -f "$folder/build.ninja" ] || again=(--reconfigure)
  mkdir -p "$folder"
  meson setup "$folder" "${again[@]}" -Dtests=enabled -Dvision=enabled -Ddevice=enabled -Dtrack=enabled -Ddebug=false \
    "$@" >"$folder/build.log" 2>&1 || { tail -n 40 "$folder/build.log"; return 1; }
}

# `compile FOLDER TARGET...`
compile() {
  local folder=$1
  shift
  # Other commands were still running when one failed: its message is not the last.
  ninja -C "$folder" "$@" >>"$folder/build.log" 2>&1 ||
    { grep -A 30 '^FAILED:' "$folder/build.log" || tail -n 40 "$folder/build.log"; return 1; }
}

# A sixth of the headers are read if the sources of a library are compiled six at a time. (Meson 1.0 takes a multiple of
# that number for one file more, which is not there. No library that another one takes whole has 6 or 12 files.)
unity=(-Dunity=on -Dunity_size=6)

# Suites of other steps, or of other sizes.
other_suites=(realtime hil long lab)
[ "$size" != quick ] || other_suites+=(web docs fuzz)

# What the tests of this size need. The lab and the benchmarks, which only --all needs, are a fifth of the whole build.
build_plain() {
  local lab=disabled programs=()
  [ "$size" != all ] || lab=enabled
  configure build-tests -Dwerror=true "${unity[@]}" -Dbenchmarks=$lab -Ddocumentation-uri="file://$root/build-site" || return
  [ "$size" != quick ] || mapfile -t programs < <(of_suites programs build-tests not "${other_suites[@]}")
  compile build-tests "${programs[@]}"
}

# All elements and what goes wrong around them, USB, and the unit tests of what reads bytes of others: tracks and `spidar`.
# Those of the rooms `vision` and `device`, which mostly compute, would take half as long again. The elements run the same
# code, with the best instructions of this processor; --all has them all, but for SSSE3.
sanitized_suites=(elements faults usb fuzz)
if [ "$size" = all ]; then
  sanitized_suites+=(unit)
else
  sanitized_suites+=(unit-common unit-spidar unit-track)
fi

# `of_suites WHAT FOLDER [SUITE...] [not SUITE...]`: WHAT is `programs`, what the tests of these suites, or else of all,
# need (their programs and the plugins), or `realtime`, the names of those tests of real time.
of_suites() {
  meson introspect --tests --targets "$2" | python3 -c 'import json, os, sys
what, folder, *named = sys.argv[1:]
found = json.load(sys.stdin)
suites = lambda test: {suite.split(":")[-1] for suite in test["suite"]}
at = (named + ["not"]).index("not")
tests = [test for test in found["tests"]
         if (not at or suites(test) & set(named[:at])) and not suites(test) & set(named[at + 1:])]
needed = {name for test in tests for name in test["depends"]}
if what == "realtime":
    print(*(test["name"] for test in tests if "realtime" in suites(test)), sep="\n")
else:
    for target in found["targets"]:
        if target["id"] in needed or target["type"] == "shared module":
            print(*(os.path.relpath(name, folder) for name in target["filename"]), sep="\n")' "$@"
}

# Clang needs a third of GCC's time, if it can link with the sanitizers. Less optimised, which halves the time again. Only
# what its tests need.
build_sanitized() {
  local programs other=()
  [ "$size" = all ] || other=(not realtime)
  if echo 'int main() {}' | clang++-22 -fsanitize=address,undefined -x c++ -o /dev/null - 2>/dev/null; then
    local ccache=
    ! command -v ccache >/dev/null || ccache='ccache '
    local -x CC=${ccache}clang-22 CXX=${ccache}clang++-22
  fi
  configure build-sanitized "${unity[@]}" -Db_sanitize=address,undefined -Db_lundef=false -Doptimization=1 \
    -Dbenchmarks=disabled -Dview=disabled && mapfile -t programs < <(of_suites programs build-sanitized "${sanitized_suites[@]}" "${other[@]}") &&
    compile build-sanitized "${programs[@]}"
}

# `in_idle_time LOG COMMAND...` runs a command in the background, with the processor time that the tests leave.
in_idle_time() {
  local log=$1
  shift
  set -m # it gets a process group, which ends with this script
  (
    chrt --idle --pid 0 "$BASHPID" 2>/dev/null || renice -n 19 "$BASHPID" >/dev/null
    "$@"
  ) >"$log" 2>&1 &
  background=$!
  set +m
}

# `run_meson_tests PREFIX FOLDER PROCESSES OPTION...` records each test of a build folder, so many at once. The time limits
# are meant for a machine with other work.
run_meson_tests() {
  local prefix=$1 folder=$2 processes=$3 logs=$2/meson-logs status=0 start=$SECONDS used
  shift 3
  count_processor_time
  used=$processor_time
  run_and_repeat "$logs" "$processes" meson test -C "$folder" --no-rebuild --print-errorlogs "$@" || status=1
  python3 tests/summary.py collect "$prefix" "$logs" "$outputs" >"$scratch/collected" || status=1
  cat "$scratch/collected" >>"$results"
  # A run that went wrong without a failed test is a failure too, and so is one without a test.
  if [ "$status" != 0 ] || [ ! -s "$scratch/collected" ]; then
    record failed "${prefix}meson test" 0 "meson ended otherwise than by failed tests"
  fi
  count_processor_time
  record waited "$prefix$folder" $((processes * (SECONDS - start) - processor_time + used)) ''
}

# Most of them need the processor. Those of real time one at a time, so that they are not late. They mostly wait.
run_plain_tests() {
  step "Tests"
  run_meson_tests '' build-tests "$(nproc)" --timeout-multiplier 3 "${other_suites[@]/#/--no-suite=}"
  [ "$size" != quick ] || return 0
  step "Tests in real time"
  run_meson_tests '' build-tests 1 --timeout-multiplier 10 --suite realtime --no-suite long
}

# The films and programs of these wait.
run_long_tests() {
  step "Long tests"
  run_meson_tests '' build-tests "$(nproc)" --timeout-multiplier 5 --suite long
  step "The lab"
  run_meson_tests '' build-tests "$(nproc)" --timeout-multiplier 3 --suite lab
}

# Every instruction of it is emulated: what runs beside it makes its ticks late.
run_virtual_machine() {
  step "The virtual machine"
  run_meson_tests '' build-tests 1 --timeout-multiplier 3 --suite hil
}

# Whether LeakSanitizer works here: some containers forbid what it needs.
leaks_can_be_found() {
  local said
  said=$(ASAN_OPTIONS=detect_leaks=1 build-sanitized/tests/unit/unit-common --gtest_filter=nothing 2>&1) || true
  ! grep -q 'LeakSanitizer has encountered a fatal error' <<<"$said"
}

run_sanitized_tests() {
  local leaks=1 status=0 realtime again
  step "Tests with sanitizers"
  if ! leaks_can_be_found; then
    leaks=0
    echo "LeakSanitizer does not work here: leaks are not looked for."
  fi
  # Without intercept_tls_get_addr=0, LeakSanitizer sometimes reads the thread-local memory of a thread at a
  # wrong address and crashes.
  local asan=detect_leaks=$leaks:intercept_tls_get_addr=0
  local -x LSAN_OPTIONS=suppressions=$root/tests/suppressions/lsan.supp:print_suppressions=0
  local -x UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
  local -x GTEST_FILTER
  GTEST_FILTER=$(without_repetitions)
  # The slow unwinder takes up to twenty times as long as the fast one. But only it can tell a leak from GLib's own, since
  # Debian's GLib has no frame pointers: it judges again what failed with the fast one.
  local -x ASAN_OPTIONS=$asan:fast_unwind_on_malloc=1
  rm -f build-sanitized/meson-logs/{testlog.json,alone}
  meson test -C build-sanitized --no-rebuild --num-processes "$(nproc)" "${sanitized_suites[@]/#/--suite=}" \
    --no-suite realtime --timeout-multiplier 10 </dev/null || status=$?
  python3 tests/summary.py first 'sanitized ' build-sanitized/meson-logs "$outputs" >>"$results"
  mapfile -t again < <(python3 tests/summary.py failed build-sanitized/meson-logs/testlog.json | cut -f 1 | sort -u)
  # The status is the number of failed tests.
  [ "$status" = ${#again[@]} ] ||
    record failed "sanitized meson test" 0 "meson ended otherwise than by failed tests"
  ASAN_OPTIONS=$asan:fast_unwind_on_malloc=0
  [ ${#again[@]} = 0 ] ||
    run_meson_tests 'sanitized ' build-sanitized "$(nproc)" --timeout-multiplier 10 "${again[@]}"
  [ "$size" = all ] || return 0
  # Without what makes them slow: one seed has shown the leaks. With blocks of GLib's slices, a use after the end shows
  # only by chance.
  ASAN_OPTIONS=detect_leaks=0:intercept_tls_get_addr=0 G_SLICE=always-malloc FEELING_WIND_SEEDS=20 \
    run_meson_tests '20 seeds, sanitized ' build-sanitized 1 --timeout-multiplier 10 element-torture
  mapfile -t realtime < <(of_suites realtime build-sanitized "${sanitized_suites[@]}")
  run_meson_tests 'sanitized ' build-sanitized 1 --timeout-multiplier 10 "${realtime[@]}"
}

check_format() {
  find gst-plugins pipelines spidar tests \( -name '*.[ch]pp' -o -name '*.[ch]' \) -print0 |
    xargs -0 clang-format --dry-run --Werror
}

# Reads each source by itself, of a build that is only configured.
check_style() {
  local base=
  [ "$size" = all ] || base=${FEELING_WIND_BASE-$(git describe --tags --abbrev=0 2>/dev/null)}
  configure build-style -Dunity=off -Dbenchmarks=disabled && python3 tests/style.py build-style "$base"
}

check_scripts() {
  find changes env pipelines tests .ci \( -name '*.sh' -o -path env -o -path .ci/run -o -name haptic-film \) -print0 |
    xargs -0 -n 8 -P "$(nproc)" shellcheck -x -P SCRIPTDIR:.
}

# In a copy without a build folder; the moving picture of the README too.
check_demonstration() {
  local copy=$scratch/demonstration
  mkdir "$copy"
  tar --exclude='./build*' --exclude=./.git -cf - . | tar -xf - -C "$copy"
  "$copy/pipelines/demo.sh" --output "$copy/demo-output" &&
    "$copy/pipelines/paper/moving-picture.sh" "$copy/moving.webp"
}

# Of time, or on one processor.
run_referees() {
  check "No thread reads what another one writes" tests/referees/thread-sanitizer.sh || true
  check "The leaks that are excused are GStreamer's own" tests/referees/excused-leaks.sh || true
  check "The loop never allocates, locks or waits" tests/referees/real-time-sanitizer.sh || true
  check "Other programs read and play what haptic-track writes" tests/referees/players.sh || true
  check "Damaged files open nothing, and each command ends" tests/referees/hostile-files.sh || true
}

sanitized_builds="Everything builds with AddressSanitizer and UndefinedBehaviorSanitizer"
other_debian_builds="It builds on the other Debian"

# What needs the processors, or the network, and no test in real time.
check_beside_tests() {
  check "$sanitized_builds" build_sanitized || true
  check "Every script passes shellcheck" check_scripts || true
  if [ "$size" = gate ]; then
    check "clang-tidy finds nothing" check_style || true
    return 0
  fi
  check "$other_debian_builds" tests/other-debian.sh --part build || true
  if check "The Debian package builds here" tests/debian-package.sh build-packages; then
    check "The image of haptic-track authors a film" tests/container.sh --packages build-packages || true
  fi
  check "clang-tidy finds nothing" check_style || true
  check "It builds for arm64, and its tests pass in an emulator" tests/referees/arm64.sh || true
  check "It builds with each option on and off" tests/referees/options.sh || true
  check "The vector code runs on other processors" tests/referees/instruction-sets.sh || true
  check "The guardian's protocol leaves no force" tests/referees/guardian-model.sh || true
  check "Whatever the hand does, the force stays calm" \
    env "SPIDAR_GEOMETRY_PATH=$root/spidar/geometry" build-tests/tests/measure/force/closed-loop --threes || true
}

# `wait_for NAME` until the background has recorded this check, or has ended.
wait_for() {
  while kill -0 "$background" 2>/dev/null && ! grep -q "$1" "$results"; do sleep 1; done
}

set_up
[ "$size" = quick ] || check "The source is formatted with clang-format" check_format || true
check "It builds without a warning" build_plain || exit 0
[ "$size" = quick ] || in_idle_time build-tests/background.log check_beside_tests
run_plain_tests
[ "$size" != quick ] || exit 0

wait_for "$sanitized_builds"
! grep -q "^passed.*$sanitized_builds" "$results" || run_sanitized_tests
if [ "$size" = all ]; then
  run_referees
  run_long_tests
  check "No parser fails on damaged tracks that coverage has guided" tests/fuzz/coverage.sh 15s || true
  check "The demonstration runs as a user starts it" check_demonstration || true
  wait_for "$other_debian_builds" # they mostly wait
  check "Its tests pass on the other Debian" tests/other-debian.sh --part tests || true
fi
wait "$background" || record failed "The checks beside the tests" 0 "they ended early with status $?"
background=
cat build-tests/background.log
[ "$size" != all ] || run_virtual_machine
