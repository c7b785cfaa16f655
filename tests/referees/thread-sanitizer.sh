#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs the tests of what threads share without a lock, of the session and of the storm from every thread with
# ThreadSanitizer, which reports each access that nothing orders. It does not judge GLib and GStreamer
# (tests/suppressions/tsan.supp). Then every element is tortured by 28 threads (tests/elements/torture-test.cpp), with 20
# seeds. What GStreamer itself does wrong meanwhile is shown by control runs: the same with an element of GStreamer.
#
# Usage: tests/referees/thread-sanitizer.sh
#
# Builds in build-threads/. Where ThreadSanitizer does not run, the exit status is 77.

source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$(dirname "$0")/support.sh"

no_options "$@"

unit_tests=(
  newest-slot sample-ring field-sampler field-pool sample-intake tick-log call-queue haptic-loop haptic-loop-touch
  haptic-session session-state reopening
)
targets=(tests/unit/unit-device tests/faults/faults-loop tests/faults/faults-loop-realtime tests/elements/element-torture
  gst-plugins/vision/libgsthapticvision.so gst-plugins/track/libgsthaptictrack.so gst-plugins/device/libgsthapticdevice.so)
folder=$root/build-threads
build_sanitized "$folder" -Db_sanitize=thread -Dvision=enabled -Dtrack=enabled

cd "$folder"
# The sanitizer of GCC 12 does not start where the kernel randomises more than 28 bits of an address.
fixed_addresses=(setarch "$(uname -m)" --addr-no-randomize)
"${fixed_addresses[@]}" true 2>/dev/null || fixed_addresses=()
said=$("${fixed_addresses[@]}" tests/unit/unit-device --gtest_list_tests 2>&1) || true
if grep -q 'FATAL: ThreadSanitizer' <<<"$said"; then
  skip "ThreadSanitizer does not start with the address space of this kernel"
fi
export TSAN_OPTIONS=suppressions=$root/tests/suppressions/tsan.supp:print_suppressions=0
export SPIDAR_GEOMETRY_PATH=$root/spidar/geometry
GTEST_FILTER=$(cases_of "${unit_tests[@]}") judge "${fixed_addresses[@]}" tests/unit/unit-device
# Hours and minutes of ticks of one thread.
export GTEST_FILTER='-*.F20_*:*.F27_*'
judge "${fixed_addresses[@]}" tests/faults/faults-loop
judge "${fixed_addresses[@]}" tests/faults/faults-loop-realtime

# No other plugins of GStreamer: the libraries of some do what the sanitizer reports as soon as they are loaded.
controls=$folder/controls
mkdir -p "$controls"
for plugin in audioparsers coreelements mpegtsmux rtp; do
  ln -sf "$(pkg-config --variable=pluginsdir gstreamer-1.0)/libgst$plugin.so" "$controls/"
done
unset GTEST_FILTER
export GST_PLUGIN_SYSTEM_PATH_1_0=$controls GST_PLUGIN_PATH_1_0=$folder/gst-plugins
export GST_REGISTRY=$folder/registry.bin GST_REGISTRY_FORK=no
export G_DEBUG=fatal-criticals G_SLICE=always-malloc FEELING_WIND_SEEDS=20
# Each for itself: one that ends early hides no other. 20 seeds of one take 13 to 41 s on one processor.
mapfile -t elements < <("${fixed_addresses[@]}" tests/elements/element-torture --gtest_list_tests --gtest_filter='Elements/*' |
  sed -n 's/^  \([^ ]*\).*/\1/p')
[ ${#elements[@]} -gt 0 ] || fail "element-torture lists no element"
for element in "${elements[@]}"; do
  judge timeout 600 "${fixed_addresses[@]}" tests/elements/element-torture "--gtest_filter=Elements/Torture.$element"
done

# `control CASE REPORT`: an element of GStreamer 1.22 does the same in the same hands, in one of five runs: it may hang
# before it does, which ends after 20 s.
control() {
  local output status found=no
  output=$(mktemp)
  echo "-- control: $1"
  for _ in {1..5}; do
    status=0
    timeout -s KILL 20 "${fixed_addresses[@]}" tests/elements/element-torture --gtest_also_run_disabled_tests \
      --gtest_filter="*Controls*$1" >"$output" 2>&1 || status=$?
    echo "exit status $status" >>"$output"
    ! grep -qx ".*$2" "$output" || { found=yes && break; }
  done
  if [ $found = no ]; then
    failed=yes
    echo "there is no '$2': take the exception out of torture-test.cpp or tsan.supp"
    tail "$output"
  fi
  rm -f "$output"
}
if [[ $(pkg-config --modversion gstreamer-1.0) == 1.22.* ]]; then
  control ClipsByASegmentInBytes "gst_segment_clip: assertion 'segment->format == format' failed"
  control TakesASegmentInBytesForTime "gst_segment_to_running_time: assertion 'segment->format == format' failed"
  control WaitsForEver 'exit status 137'
  control ASegmentIsReplacedWhileItIsReadForThePosition 'exit status 0'
  control AQueryIsGivenBackWhileItIsUsed 'exit status 0'
  control ASegmentInBytesBackwardsHasNoEnd 'exit status 0'
  control TheEndOfAStreamHasNoNumberAmidAFlush 'exit status 0'
  control ASeekIsFreedTwice 'exit status 0'
  control AQueryUsesCapsThatItDoesNotHold 'exit status 0'
  # Each race that tests/suppressions/tsan.supp excuses is one of GStreamer alone.
  while read -r race name; do
    TSAN_OPTIONS='' control "$name" "SUMMARY: ThreadSanitizer: data race .* in $race"
  done < <(awk '$2 == "control:" { name = $3 } /^$/ { name = "" } sub(/^race:/, "") { print $0, name ? name : "none" }' \
    "$root/tests/suppressions/tsan.supp")
fi
[ $failed = no ]
