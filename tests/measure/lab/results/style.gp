# SPDX-License-Identifier: LGPL-2.1-or-later
# Settings of all charts of the lab. Each method has a colour and a symbol. No method has the orange of the velocity or the
# blue of the force.
load system("dirname '" . ARG0 . "'") . "/../../../../pipelines/shared/palette.gp"
set datafile separator ","
set datafile columnheaders

# `terminal(FILE, WIDTH, HEIGHT)` returns the commands that open a PNG file for output.
terminal(file, width, height) = \
  sprintf("set terminal pngcairo size %d,%d font 'DejaVu Sans,15' background '#ffffff'; set output '%s'", width, height, file)

# Methods in groups, a colour and a symbol each.
group(method) = \
  method eq "fast" ? 1 : method eq "method=opencv" ? 2 : \
  method[1:9] eq "PyrLK cro" ? 3 : method[1:9] eq "PyrLK fra" ? 4 : \
  method eq "RLOF" ? 5 : method[1:3] eq "DIS" ? 6 : method eq "Farneback" ? 7 : \
  method[1:5] eq "phase" ? 8 : method eq "ECC" ? 9 : method[1:5] eq "block" ? 10 : 0
array colour[10] = [0x882255, 0x000000, 0x009E73, 0x999933, 0x44AA99, 0xCC79A7, 0xAA4499, 0xCC6677, 0x332288, 0x777777]
array symbol[10] = [7, 5, 9, 11, 13, 15, 4, 8, 6, 12]
