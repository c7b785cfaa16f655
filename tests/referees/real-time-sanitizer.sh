#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Checks that the 1 kHz loop and LimitedDevice never allocate, lock or wait: builds their tests with Clang's
# RealtimeSanitizer, which reports each such call in a function that is marked HAPTIC_NONBLOCKING, and runs them. The
# exceptions stand in tests/suppressions/rtsan.supp.
#
# Usage: tests/referees/real-time-sanitizer.sh
#
# Builds in build-real-time/. Needs clang 20 or newer with its runtime library; without it, the exit status is 77.

source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$(dirname "$0")/support.sh"

no_options "$@"

# `find_compiler` sets $compiler to the newest clang++ that can link a program with RealtimeSanitizer.
find_compiler() {
  local version
  for version in $(compgen -c clang++- | sed -n 's/^clang++-\([0-9]*\)$/\1/p' | sort -rnu); do
    if [ "$version" -ge 20 ] &&
      echo 'int main() {}' | "clang++-$version" -fsanitize=realtime -x c++ -o /dev/null - 2>/dev/null; then
      compiler=clang++-$version
      return
    fi
  done
  skip "no clang of version 20 or newer has RealtimeSanitizer here (clang-22, libclang-rt-22-dev)"
}

# Every test that ticks the loop or LimitedDevice, or runs a part of them that is marked.
unit_tests=(
  carried-hand carry-law contact-law continuous-force field-hold force-smoothness grip-watch haptic-loop
  haptic-loop-touch haptic-session held-path limited-device motion-interpolator relief-timeline reopening safety-chain
  session-state shaking-hand slipped-string tick-log touch-loop turning-grip
)
# Its device sleeps on purpose.
sleeps="*/LoopThread.ADeviceThatHoldsItUpMakesItsNextTickAMissedOneAndTheOthersAreSkipped/*"

# A referee that no longer sees what it must report would pass everything.
check_that_it_sees() {
  local door action status
  for door in loop limits; do
    for action in heap mutex sleep; do
      status=0
      tests/referees/allocating-device "$door" "$action" >/dev/null 2>&1 || status=$?
      # 43: the sanitizer ended it.
      [ $status = 43 ] ||
        fail "a device whose exchange uses the $action was not reported through the $door;" \
          "HapticLoop::tick and LimitedDevice's exchange must be HAPTIC_NONBLOCKING"
    done
  done
}

folder=$root/build-real-time
find_compiler
targets=(tests/unit/unit-device tests/unit/unit-spidar tests/unit/unit-evdev-device tests/faults/faults-loop tests/usb/usb
  spidar/spidar-guardian tests/referees/allocating-device)
# Meson 1.0 has no name for this sanitizer.
CXX=$compiler build_sanitized "$folder" -Dcpp_args=-fsanitize=realtime -Dcpp_link_args=-fsanitize=realtime
cd "$folder"
# A name of each function, which the exceptions need, also without the package llvm.
symbolizer=$(command -v llvm-symbolizer || command -v addr2line)
export RTSAN_OPTIONS=external_symbolizer_path=$symbolizer:suppressions=$root/tests/suppressions/rtsan.supp:print_suppressions=0
export SPIDAR_GEOMETRY_PATH=$root/spidar/geometry SPIDAR_GUARDIAN=$folder/spidar/spidar-guardian
judge tests/referees/allocating-device loop nothing
judge tests/referees/allocating-device limits nothing
check_that_it_sees
filter=$(cases_of "${unit_tests[@]}")
GTEST_FILTER=$filter-$sleeps judge tests/unit/unit-device
GTEST_FILTER=$filter judge tests/unit/unit-spidar
judge tests/unit/unit-evdev-device
judge tests/faults/faults-loop
# An exchange takes 60 ms here: the name of each function of each call into libusb is looked up.
FEELING_WIND_TICKS=100 judge umockdev-wrapper tests/usb/usb --gtest_filter='*/Ticks.*:OurPart.*'
[ $failed = no ]
