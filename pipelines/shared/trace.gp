# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws the trace of hapticsink: velocity under the hand and force on it, over time, as the paper's
# figure 11. In both panels up and right are positive (the log counts vy downwards).
#
#   gnuplot -c trace.gp TRACE.csv PLOT.png TITLE
if (ARGC != 3) { print "usage: gnuplot -c trace.gp TRACE.csv PLOT.png TITLE"; exit status 1 }
load system("dirname '" . ARG0 . "'") . "/palette.gp"

set terminal pngcairo size 1200,800 font "DejaVu Sans,17" background "white"
set output ARG2
set datafile separator ","
set datafile columnheaders
set xzeroaxis linetype -1 linecolor rgb "#444444"
set xrange [0:*] noextend
set y2range [0:1]
set key at screen 0.98, 0.92 # below the title
set offsets 0, 0, 0.05, 0.05

# In grey, below the curves: when nothing was measured.
unmeasured = 'ARG1 using (column("time")):(column("confidence") > 0 ? 0 : 1) axes x1y2 with fillsteps linecolor rgb "#E8E8E8"'

set multiplot layout 2,1 title ARG3 noenhanced margins 0.10, 0.98, 0.11, 0.87 spacing 0, 0.07
set format x ""
set ylabel "velocity (px/s)"
plot @unmeasured title "not measured", \
     ARG1 using (column("time")):(column("vx")) with lines linetype 11 title "to the right", \
     ARG1 using (column("time")):(-column("vy")) with lines linetype 12 title "upwards"
unset key
set format x "%g"
set ylabel "force (N)"
set xlabel "time (s)"
plot @unmeasured, \
     ARG1 using (column("time")):(column("fx")) with lines linetype 13, \
     ARG1 using (column("time")):(column("fy")) with lines linetype 14
unset multiplot
