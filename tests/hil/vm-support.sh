# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034 # its variables are read by the scripts that source it
# What the scripts share that run in the virtual machine: the emulator on its USB, and assertions
# about what the motors were told. To be sourced.

source "$(dirname "${BASH_SOURCE[0]}")/../../pipelines/shared/common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/promise.sh"

export SPIDAR_GEOMETRY_PATH=${SPIDAR_GEOMETRY_PATH:-$root/spidar/geometry}
work=$(mktemp -d)
words=$work/words.csv
usb_ticks=$build/tests/hil/usb-ticks

# At the minimum tension of the default geometry, 0.3 N, a D/A word is at most this.
least_word=46

# Emulated processors are slow: an exchange may take longer there than on any machine with a device. measure_the_bus
# raises it to ten times the median.
export SPIDAR_USB_TIMEOUT=100 # ms
export SPIDAR_GUARDIAN=$build/spidar/spidar-guardian

# `within SECONDS COMMAND...`: the command succeeds before the time is over.
within() {
  local end=$((SECONDS + $1 + 1))
  shift
  until "$@" >/dev/null 2>&1; do
    [ $SECONDS -lt $end ] || return 1
    sleep 0.1
  done
}

# Starts the emulator with its D/A log; `tell COMMAND` then injects faults.
start_emulator() {
  modprobe vhci-hcd
  mkfifo "$work/commands"
  # As a device has a processor of its own, the emulator goes before other programs.
  chrt -f 40 "$build/spidar/emulator/spidar-emulator" --log "$words" "$@" <"$work/commands" >"$work/emulator" &
  exec 3>"$work/commands"
  within 20 test -e /sys/devices/platform/vhci_hcd.0/status || fail "the kernel has no vhci-hcd"
  within 20 grep -q listening "$work/emulator" || fail "the emulator does not start"
}

tell() {
  local answers
  answers=$(wc -l <"$work/emulator")
  echo "$*" >&3
  within 10 more_lines "$answers" "$work/emulator"
  tail -n 1 "$work/emulator" | grep -qx ok || fail "the emulator refused: $*"
}

more_lines() {
  [ "$(wc -l <"$2")" -gt "$1" ]
}

# `attach UNIT PRODUCT`: until the kernel sees it.
attach() {
  within 20 usbip attach -r 127.0.0.1 -b "1-$1" && within 20 on_the_bus "$2"
}

on_the_bus() {
  lsusb -d "0cec:$1"
}

# Sets exchange_time, µs, and the time limit of the driver.
measure_the_bus() {
  exchange_time=$("$usb_ticks" probe) || fail "the probe failed"
  echo "an exchange of two transfers takes $exchange_time µs (median); more than 500 µs is too slow for 1 kHz"
  [ "$exchange_time" -le 10000 ] || SPIDAR_USB_TIMEOUT=$((exchange_time < 100000 ? exchange_time / 100 : 1000))
}

# `value NAME LINE`: of a line NAME VALUE NAME VALUE ...
value() {
  # shellcheck disable=SC2086 # the words of the line
  printf '%s\n' $2 | sed -n "/^$1\$/{n;p}"
}

# `told CONDITION`: of the D/A log, as awk sees it: `largest`, the largest word of the last row that
# the host set; `rows`; `after`, ms from the last row above the minimum tension to the next.
told() {
  sleep 0.2 # until the emulator has written
  awk -F, -v least="$least_word" '
    $3 != "words" { next }
    {
      rows++
      largest = 0
      for (i = 4; i <= 11; i++) { word = $i < 0 ? -$i : $i; if (word > largest) largest = word }
      if (above) after = ($1 - time) * 1000
      above = largest > least
      time = $1
    }
    END { if (!('"$1"')) { print "rows " rows ", largest " largest ", after " after " ms"; exit 1 } }' "$words"
}
