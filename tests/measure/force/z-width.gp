# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws what z-width writes.
#
#   gnuplot -c z-width.gp FOLDER PICTURE.png
#
# FOLDER has geometry.txt, hand.txt, rate.txt and lateness.txt.
if (ARGC != 2) { print "usage: gnuplot -c z-width.gp FOLDER PICTURE.png"; exit status 1 }

load system("dirname '" . ARG0 . "'") . "/../../../pipelines/shared/palette.gp"

set terminal pngcairo size 1200,1000 font "DejaVu Sans,15" background "white"
set output ARG2
set logscale y
set xrange [0:8]
set yrange [10:200000]
set xlabel "damping of the wall (N·s/m)"
set ylabel "stiffness of the wall (N/m)"
set key inside top right vertical maxrows 4 samplen 2
set linetype 4 linecolor rgb "#000000" linewidth 1.5 pointtype 7
set multiplot layout 2,2
# Even blocks are curves, odd ones their theory.
do for [panel in "geometry hand rate lateness"] {
  file = ARG1 . "/" . panel . ".txt"
  set title panel
  plot for [i=0:3] file index 2*i using 1:2 with linespoints linetype i+1 pointtype 7 pointsize 0.6 \
      title columnheader(1), \
    for [i=0:3] file index 2*i+1 using 1:2 with lines linetype i+1 dashtype 2 notitle
}
unset multiplot
