#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs the tests of what threads share without a lock, of the session and of the storm from every thread with
# ThreadSanitizer, which reports each access that nothing orders. It does not judge GLib and GStreamer
# (tests/suppressions/tsan.supp). Then every element is tortured by many threads (tests/elements/torture-test.cpp).
#
# Usage: tests/referees/thread-sanitizer.sh
#
# Builds in build-threads/ and build-threads-elements/. Where ThreadSanitizer does not run, the exit status is 77.

source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$(dirname "$0")/support.sh"

no_options "$@"

unit_tests=(newest-slot sample-ring field-sampler sample-intake tick-log call-queue haptic-loop haptic-session)
targets=("${unit_tests[@]/#/tests/unit/unit-}" tests/faults/faults-loop tests/faults/faults-loop-realtime)
folder=$root/build-threads
build_sanitized "$folder" -Db_sanitize=thread

cd "$folder"
# The sanitizer of GCC 12 does not start where the kernel randomises more than 28 bits of an address.
fixed_addresses=(setarch "$(uname -m)" --addr-no-randomize)
"${fixed_addresses[@]}" true 2>/dev/null || fixed_addresses=()
if "${fixed_addresses[@]}" tests/unit/unit-newest-slot --gtest_list_tests 2>&1 | grep -q 'FATAL: ThreadSanitizer'; then
  skip "ThreadSanitizer does not start with the address space of this kernel"
fi
export TSAN_OPTIONS=suppressions=$root/tests/suppressions/tsan.supp:print_suppressions=0
export SPIDAR_GEOMETRY_PATH=$root/spidar/geometry
# Hours and minutes of ticks of one thread.
export GTEST_FILTER='-*.F20_*:*.F27_*'
for unit in "${unit_tests[@]}"; do
  judge "${fixed_addresses[@]}" "tests/unit/unit-$unit"
done
judge "${fixed_addresses[@]}" tests/faults/faults-loop
judge "${fixed_addresses[@]}" tests/faults/faults-loop-realtime

# With OpenCV and all plugins.
targets=(tests/elements/element-torture gst-plugins/vision/libgsthapticvision.so gst-plugins/track/libgsthaptictrack.so
  gst-plugins/device/libgsthapticdevice.so)
folder=$root/build-threads-elements
build_sanitized "$folder" -Db_sanitize=thread -Dvision=enabled -Dtrack=enabled
cd "$folder"
# A task of GStreamer frees in its own thread what the pool made, under a lock that the sanitizer does not see. Its
# functions have no name that a suppression could give.
export GTEST_FILTER='-*pointerextract:*hapticarray'
export GST_PLUGIN_PATH_1_0=$folder/gst-plugins GST_REGISTRY=$folder/registry.bin GST_REGISTRY_FORK=no
export G_DEBUG=fatal-criticals G_SLICE=always-malloc FEELING_WIND_SEEDS=20
judge "${fixed_addresses[@]}" tests/elements/element-torture
[ $failed = no ]
