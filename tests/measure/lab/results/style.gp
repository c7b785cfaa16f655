# SPDX-License-Identifier: LGPL-2.1-or-later
# Settings of all charts of the lab. The colours are those of the palette and more; each method also has
# its own symbol.
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
array colour[10] = [0xD55E00, 0x000000, 0x0072B2, 0x56B4E9, 0x009E73, 0xCC79A7, 0xE69F00, 0x882255, 0x999933, 0x777777]
array symbol[10] = [7, 5, 9, 11, 13, 15, 4, 8, 6, 12]
