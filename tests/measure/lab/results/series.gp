# SPDX-License-Identifier: LGPL-2.1-or-later
# Cost against frame size, region size and number of points; error against number of points,
# displacement, phase, noise and contrast.
#
#   gnuplot -c series.gp FOLDER CHART.png    (FOLDER contains series.csv)
if (ARGC != 2) { print "usage: gnuplot -c series.gp FOLDER CHART.png"; exit status 1 }
load system("dirname '" . ARG0 . "'") . "/style.gp"
table = ARG1 . "/series.csv"

eval(terminal(ARG2, 1400, 2200))
unset key
set datafile missing NaN

of(series, method, value) = strcol("series") eq series && strcol("method") eq method ? value : NaN
# One line per method as shipped; of DIS, only the preset "fast". Those after the fifth are grey.
methods = "'fast' 'method=opencv' 'PyrLK crop' 'PyrLK frame' 'DIS fast' 'RLOF' 'Farneback' 'phase correlation' 'ECC' 'block search'"
shade(g) = g > 5 ? 0xC0C0C0 : colour[group(word(methods, g))]
mark(g) = symbol[group(word(methods, g))]

curves = 'for [g = shown:1:-1] table using (of(series, word(methods, g), column("x"))):(column(what)) ' . \
  'pointtype mark(g) pointsize 0.9 linecolor rgb shade(g) linewidth (g == 1 ? 3 : 1.5) notitle'
# The Cramér-Rao bound is plotted by a separate command: a `for` loop with no pass would still scale
# the axis.
bound = 'table using (of(series, "bound", column("x"))):(column("error")) ' . \
  'with lines dashtype 2 linecolor rgb "#444444" linewidth 1.5 notitle'

set multiplot layout 4, 2 margins 0.095, 0.98, 0.085, 0.975 spacing 0.115, 0.07
set style data linespoints
do for [panel in "frame region points accuracy displacement phase noise contrast"] {
  unset logscale
  set autoscale
  set xrange [*:*] noextend
  set format "%g"
  set xtics autofreq
  series = panel eq "accuracy" ? "points" : panel
  what = panel eq "frame" || panel eq "region" || panel eq "points" ? "us_p50" : panel eq "phase" ? "bias" : "error"
  set logscale y
  if (panel eq "frame" || panel eq "region" || panel eq "contrast") { set logscale x }
  set ylabel what eq "us_p50" ? "median time (µs)" : what eq "bias" ? "length of the mean error (px)" : "mean error (px)"
  if (panel eq "frame") { set title "Cost against the size of the frame, region 30 px"; set xlabel "million pixels"; set xtics (0.1, 0.3, 1, 3, 8) }
  if (panel eq "region") { set title "Cost against the side of the region"; set xlabel "px"; set xtics (16, 24, 32, 48, 64, 96, 128) }
  if (series eq "points") { set logscale x 2; set xlabel "most points" }
  if (panel eq "points") { set title "Cost against the number of points, region 60 px that turns by 5°" }
  if (panel eq "accuracy") { set title "Error against the number of points, the same" }
  if (panel eq "displacement") { set title "Error against displacement"; set xlabel "px per frame" }
  if (panel eq "phase") { set title "Bias against the fraction of a pixel"; set xlabel "px" }
  if (panel eq "noise") { set title "Error against noise"; set xlabel "standard deviation (grey levels)" }
  if (panel eq "contrast") { set title "Error against contrast, noise 1.5"; set xlabel "of full contrast" }
  shown = series eq "points" ? 3 : 10 # only the first three have a number of points
  eval("plot " . curves . (what eq "error" && series ne "points" ? ", " . bound : ""))
}

unset logscale; unset xlabel; unset ylabel; unset title; unset border; unset tics; unset grid
set lmargin at screen 0.02; set rmargin at screen 0.98; set bmargin at screen 0.005; set tmargin at screen 0.055
set key inside center center horizontal maxrows 3 samplen 2 width 1
set xrange [0:1]; set yrange [0:1]
plot for [g = 1:10] NaN with linespoints pointtype mark(g) linecolor rgb shade(g) linewidth (g == 1 ? 3 : 1.5) title word(methods, g), \
  NaN with lines dashtype 2 linecolor rgb "#444444" linewidth 1.5 title "Cramér–Rao bound"
unset multiplot
