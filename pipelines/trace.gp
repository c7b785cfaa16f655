# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws the trace of hapticsink: velocity under the hand and force on it, over time, as the paper's
# figure 11. In both panels up and right are positive (the log counts vy downwards).
#
#   gnuplot -c trace.gp TRACE.csv PLOT.png TITLE
if (ARGC != 3) { print "usage: gnuplot -c trace.gp TRACE.csv PLOT.png TITLE"; exit status 1 }

set terminal pngcairo size 1200,800 font "DejaVu Sans,15" background "white"
set output ARG2
set datafile separator ","
set datafile columnheaders

# Blue and vermillion of Okabe and Ito, which suit every kind of colour vision, in two widths.
set linetype 1 linecolor rgb "#0072B2" linewidth 2.5
set linetype 2 linecolor rgb "#D55E00" linewidth 1.5
set border 3 linecolor rgb "#444444"
set tics nomirror out
set grid linecolor rgb "#CCCCCC" linewidth 1
set xzeroaxis linetype -1 linecolor rgb "#444444"
set key outside top right horizontal samplen 3
set lmargin 10
set rmargin 3
set offsets graph 0, 0, 0.05, 0.05

set multiplot layout 2,1 title ARG3 noenhanced
set ylabel "velocity under the hand (px/s)"
plot ARG1 using (column("time")):(column("vx")) with lines linetype 1 title "to the right", \
     ARG1 using (column("time")):(-column("vy")) with lines linetype 2 title "upwards"
set ylabel "force on the hand (N)"
set xlabel "time (s)"
plot ARG1 using (column("time")):(column("fx")) with lines linetype 1 title "to the right", \
     ARG1 using (column("time")):(column("fy")) with lines linetype 2 title "upwards"
unset multiplot
