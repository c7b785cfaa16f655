# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws what force-trace writes.
#
#   gnuplot -c force-chart.gp TRACE.csv PICTURE.png
if (ARGC != 2) { print "usage: gnuplot -c force-chart.gp TRACE.csv PICTURE.png"; exit status 1 }

load system("dirname '" . ARG0 . "'") . "/../../../pipelines/shared/palette.gp"

set terminal pngcairo size 1200,800 font "DejaVu Sans,17" background "white"
set output ARG2
set datafile separator ","
set datafile columnheaders
set lmargin 10
set rmargin 3

style(i) = i == 2 ? 3 : i == 3 ? 2 : 13 # "hold" in grey, what is felt in the colour of the force
begin = 1.0
set multiplot layout 2,1
set ylabel "force to the right (N)"
set xrange [begin:begin + 2.5]
plot for [i=2:4] ARG1 using 1:i with lines linetype style(i) title columnheader(i)
unset key
set xlabel "time (s)"
set xrange [begin + 0.6:begin + 1.1]
plot for [i=2:4] ARG1 using 1:i with lines linetype style(i)
unset multiplot
