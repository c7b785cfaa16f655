#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# In the virtual machine: libspidar on a USB bus of the kernel, both controllers, with faults.
#
# HIL_SECONDS: how long each controller is driven, 3. Times are printed. They count only where an exchange takes less
# than 0.5 ms: then 1000 ticks in every second, no exchange lost, and the motors of a killed program at rest in 100 ms.

source "$(dirname "$0")/vm-support.sh"
seconds=${HIL_SECONDS:-3}

start_emulator --controller simple:10 --controller sh4:3
promise "the kernel sees a USB2.0 Simple" attach 1 0203
promise "the kernel sees a USB2.0 SH4" attach 2 0205
measure_the_bus
least_rate=0 most_lost=$((seconds * 1000)) most_after=1000000
if [ "$exchange_time" -lt 500 ]; then
  least_rate=1000 most_lost=0 most_after=100
fi

driven() {
  local line
  line=$(chrt -f 50 "$usb_ticks" "$seconds" "$1") || return
  echo "$line"
  [ "$(value rate "$line")" -gt 0 ] && [ "$(value lost-at-the-end "$line")" = 0 ] &&
    [ "$(value lost "$line")" -le "$most_lost" ] && [ "$(value slowest-second "$line")" -ge "$least_rate" ]
}
promise "the USB2.0 Simple is driven" driven 10
promise "the USB2.0 SH4 is driven" driven 3
promise "both are left at minimum tension" told "rows > 50 && largest <= least"
# `reports COMMAND...`: it passes or finds a broken promise; another status is a crash.
reports() {
  local status=0
  "$@" || status=$?
  [ "$status" -le 1 ]
}
# It stops and kills guardians by the clock: what it finds counts where its times count.
if [ "$exchange_time" -lt 500 ]; then
  promise "spidar-check finds no broken promise" "$build/spidar/tools/spidar-check" --device usb:3 --yes
else
  promise "spidar-check comes to its end" reports "$build/spidar/tools/spidar-check" --device usb:3 --yes
  on_the_bus 0205 || attach 2 0205
fi

# Returns once the program measures. Its first exchanges wait for taut strings and forgive faults; on a slow machine
# these may be a thousand.
start_driving() {
  : >"$work/line"
  chrt -f 50 "$usb_ticks" "$@" >"$work/line" &
  program=$!
  within 40 grep -qx driving "$work/line"
}

# Returns once the motors have heard from the program again, after what the emulator had not yet written.
some_exchanges() {
  sleep 0.3
  within 20 more_lines $(($(wc -l <"$words") + 3)) "$words"
}

# `survives ID FAULT...`: exchanges are lost, and the last ones before the program ends are not.
survives() {
  start_driving 60 "$1" || return
  shift
  for fault; do
    tell "$fault"
    some_exchanges
  done
  within 20 more_lines $(($(wc -l <"$words") + 20)) "$words"
  kill -TERM "$program"
  wait "$program" || return
  cat "$work/line"
  [ "$(value lost "$(cat "$work/line")")" -gt 0 ] && [ "$(value lost-at-the-end "$(cat "$work/line")")" = 0 ]
}
promise "short replies are survived" survives 10 "short 3 @1"
promise "late replies are survived" survives 3 "late $((2 * SPIDAR_USB_TIMEOUT)) @2" "late 0 @2"
promise "a halted endpoint is survived" survives 10 "stall in @1"

# The endpoint takes nothing while there is a force. What it takes first then are rest words.
rests_first() {
  start_driving 60 10 || return
  some_exchanges
  tell "refuse @1"
  sleep 1
  tell "accept @1"
  some_exchanges
  kill -TERM "$program"
  wait "$program" || return
  awk -F, -v least="$least_word" '
    $3 == "accept @1" { accepted = 1; next }
    accepted == 1 && $2 == 1 && $3 == "words" {
      accepted = 2
      for (i = 4; i <= 11; i++) if ($i > least + 0 || -$i > least + 0) above = 1
    }
    END { exit !(accepted == 2 && !above) }' "$words"
}
promise "an endpoint that takes data again gets rest words first" rests_first

# A guardian that stands still: no force until it answers.
unguarded() {
  local guardian
  start_driving 60 10 || return
  some_exchanges
  told "largest > least" || return
  guardian=$(pidof spidar-guardian) || return
  kill -STOP "$guardian"
  within 20 told "largest <= least" || return
  some_exchanges
  told "largest <= least" || return
  kill -CONT "$guardian"
  within 20 told "largest > least" || return
  kill -TERM "$program"
  wait "$program"
}
promise "a stopped guardian leaves no force until it goes on" unguarded

gone() {
  local status=0
  start_driving 60 10 || return
  tell "unplug @1"
  wait "$program" || status=$?
  cat "$work/line"
  [ "$status" = 2 ] && ! on_the_bus 0203
}
promise "an unplugged unit is noticed" gone
tell "replug @1"
promise "the unit can be attached anew" attach 1 0203
promise "and driven" "$usb_ticks" 1 10

killed() {
  start_driving 60 "$1" || return
  sleep 0.5
  told "rows > 0 && largest > least" || return
  kill -9 "$program"
  within 20 told "largest <= least"
  told "largest <= least && after <= $most_after"
}
if [ -n "$(find "$build/spidar" -name spidar-guardian -type f)" ]; then
  promise "the motors of a killed program go to minimum tension" killed 10
fi
