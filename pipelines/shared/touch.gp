# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws the trace of a hand that touches: its height over the middle of the workspace with that of the surface, and the
# force, over time.
#
#   gnuplot -c touch.gp TRACE.csv PLOT.png TITLE
if (ARGC != 3) { print "usage: gnuplot -c touch.gp TRACE.csv PLOT.png TITLE"; exit status 1 }
load system("dirname '" . ARG0 . "'") . "/palette.gp"

set terminal pngcairo size 1200,800 font "DejaVu Sans,17" background "white"
set output ARG2
set datafile separator ","
set datafile columnheaders
set xzeroaxis linetype -1 linecolor rgb "#444444"
set xrange [0:*] noextend

# The ranges: gnuplot would complain of a curve that is constant.
low = 1e9
high = -1e9
include(name) = sprintf('stats ARG1 using (column("%s")) nooutput; low = STATS_min < low ? STATS_min : low; high = STATS_max > high ? STATS_max : high', name)
eval include("z")
eval include("pz")
lowest = 1000 * low - 1 # mm
highest = 1000 * high + 1
low = 0
high = 0
eval include("fx")
eval include("fy")
eval include("fz")

set multiplot layout 2,1 title ARG3 noenhanced margins 0.10, 0.98, 0.11, 0.87 spacing 0, 0.11
set format x ""
set key at screen 0.98, 0.93
set yrange [lowest:highest]
set ylabel "height (mm)"
plot ARG1 using (column("time")):(column("touch") > 0 ? 1000 * column("pz") : NaN) with lines linetype 2 title "the surface under it", \
     ARG1 using (column("time")):(1000 * column("z")) with lines linetype 16 title "the hand"
set format x "%g"
set key at screen 0.98, 0.49
set yrange [low - 0.1:high + 0.1]
set ylabel "force (N)"
set xlabel "time (s)"
plot ARG1 using (column("time")):(column("fz")) with lines linetype 15 title "towards the user", \
     ARG1 using (column("time")):(column("fx")) with lines linetype 13 title "to the right", \
     ARG1 using (column("time")):(column("fy")) with lines linetype 14 title "upwards"
unset multiplot
