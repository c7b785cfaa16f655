# SPDX-License-Identifier: LGPL-2.1-or-later
# Puts the meaning of each mark beside a frame of the overlay; overlay-pictures.sh sets pipelines and work.
load pipelines . "/shared/palette.gp"
set terminal pngcairo size 960,360 font "DejaVu Sans,11" background "white"
set output work . "/marks.png"
unset key; unset border; unset tics; unset grid; unset colorbox
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
set xrange [0:960]
set yrange [0:360]
row(n) = 330 - 52 * n
# The same marks as in the frame, each in its colour and outline.
do for [edge = 0:1] {
  width(line) = line + (edge ? 0 : 3)
  set object 10 + edge rectangle from 510,row(0) - 14 to 538,row(0) + 14 front fillstyle empty \
    border linecolor rgb (edge ? "#FFFFFF" : "#000000") linewidth (edge ? 1.5 : 4.5)
  set arrow 20 + edge from 504,row(2) to 544,row(2) front linewidth width(4) \
    linecolor rgb (edge ? "#E69F00" : "#888888")
  set arrow 30 + edge from 504,row(3) to 544,row(3) front linewidth width(4) \
    linecolor rgb (edge ? "#0072B2" : "#888888")
}
do for [n = 0:2] {
  set arrow 40 + n from 508 + 14 * n,row(1) - 6 to 508 + 14 * n,row(1) + 8 front nohead linewidth 2 \
    linecolor rgb "#E69F00"
  set object 50 + n circle at 508 + 14 * n,row(1) - 6 size 3 front fillstyle solid noborder fillcolor rgb "#E69F00"
}
set object 60 rectangle from 498,row(4) - 13 to 550,row(4) + 13 front fillstyle solid noborder fillcolor rgb "#666666"
set label 1 "1.00" at 524,row(4) center front textcolor rgb "#FFFFFF"
set object 70 circle at 524,row(5) size 9 front fillstyle empty border linecolor rgb "#009E73" linewidth 3
set label 10 "the region that is felt, with the hand in its middle" at 566,row(0)
set label 11 "a patch, and where it moved since the frame before" at 566,row(1)
set label 12 "the velocity under the hand" at 566,row(2)
set label 13 "the force on the hand" at 566,row(3)
set label 14 "the simplest motion that fits, and its confidence" at 566,row(4)
set label 15 "what is held, with its path (only while you press)" at 566,row(5)
plot work . "/measured.png" binary filetype=png with rgbimage
