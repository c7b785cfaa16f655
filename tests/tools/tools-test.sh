#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The tools as a person uses them, with the simulated device.
# Usage: tools-test.sh SPIDAR-INFO SPIDAR-CALIBRATE

info=$1 calibrate=$2
source "$(dirname "$0")/expect.sh"

expect 0 'Usage' "$info" --help
expect 0 'Exit status' "$calibrate" --help
expect 1 '--help names' "$info" --colour
expect 1 "'more' is not understood" "$info" more
expect 1 'usb, usb:ID' "$info" --device serial
expect 1 '0 to 15' "$info" --device usb:16
expect 2 "No geometry 'nothing'" "$info" --device sim --geometry nothing
expect 0 'position 12.' "$info" --device sim --sim-hand hold:0.5,0,0 --seconds 0.05
expect 0 'tensions' "$info" --device sim
sed 's/^\[device\]/&\nbutton-bit=2\nbutton-pressed=1/' "$SPIDAR_GEOMETRY_PATH/spidar-g6x3r.ini" >"$work/button.ini"
for pressed in 0 1; do
  echo "0,0,0,0,$pressed" >"$work/hand"
  [ "$pressed" = 1 ] && shown='0x0004  pressed' || shown='0x0000  not pressed'
  expect 0 "inputs   $shown" "$info" --device sim --geometry "$work/button.ini" --sim-hand "file:$work/hand"
done
# `interrupted COMMAND...`: Ctrl-C once it has printed something.
interrupted() {
  local process
  : >"$work/printed"
  "$@" >"$work/printed" &
  process=$!
  while kill -0 "$process" 2>/dev/null && [ ! -s "$work/printed" ]; do sleep 0.05; done
  kill -INT "$process"
  wait "$process" && echo Ctrl-C was heeded
}
expect 0 'Ctrl-C was heeded' interrupted "$info" --device sim --watch
echo '[device]' >"$work/broken.ini"
expect 6 'broken.ini' "$info" --device sim --geometry "$work/broken.ini"
if [ ! -d /sys/bus/usb/devices ] || ! grep -qsi 0cec /sys/bus/usb/devices/*/idVendor; then
  expect 2 'Plug it in' "$info"
  expect 2 'No SPIDAR-G' "$calibrate" --output "$work/x.ini"
fi

expect 1 '--output' "$calibrate" --device sim
[ "$failed" = 0 ]
