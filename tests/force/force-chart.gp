# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws what force-trace writes.
#
#   gnuplot -c force-chart.gp TRACE.csv PICTURE.png
if (ARGC != 2) { print "usage: gnuplot -c force-chart.gp TRACE.csv PICTURE.png"; exit status 1 }

set terminal pngcairo size 1200,800 font "DejaVu Sans,15" background "white"
set output ARG2
set datafile separator ","
set datafile columnheaders

# Of Okabe and Ito: told apart by all kinds of colour vision, and by their width.
set linetype 1 linecolor rgb "#999999" linewidth 1.5
set linetype 2 linecolor rgb "#0072B2" linewidth 2.5
set linetype 3 linecolor rgb "#D55E00" linewidth 1.5
set border 3 linecolor rgb "#444444"
set tics nomirror out
set grid linecolor rgb "#CCCCCC" linewidth 1
set key outside top right horizontal samplen 3
set lmargin 10
set rmargin 3

begin = 1.0
set multiplot layout 2,1
set ylabel "force to the right (N)"
set xrange [begin:begin + 2.5]
plot for [i=2:4] ARG1 using 1:i with lines linetype (i - 1) title columnheader(i)
set xlabel "time (s)"
set xrange [begin + 0.6:begin + 1.1]
plot for [i=2:4] ARG1 using 1:i with lines linetype (i - 1) title columnheader(i)
unset multiplot
