# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws one of the paper's figures to standard output; paper.sh sets figure, work, width and height.
set terminal pngcairo size 1100,620 font "DejaVu Sans,14" background "white"
set datafile separator ","
set datafile columnheaders

# The palette of Okabe and Ito suits every kind of colour vision; widths differ too.
set linetype 1 linecolor rgb "#0072B2" linewidth 2.5 pointtype 7 pointsize 0.8
set linetype 2 linecolor rgb "#D55E00" linewidth 1.5 pointtype 6 pointsize 1.4
set linetype 3 linecolor rgb "#999999" linewidth 1.5 pointtype 7 pointsize 0.3
set border 3 linecolor rgb "#444444"
set tics nomirror out
set grid linecolor rgb "#CCCCCC" linewidth 1
set key outside top right horizontal samplen 3

half = 25.0       # mm, half the workspace of the default geometry
f_max = 1.0       # N
alpha = 0.01      # s/px
reference = 352.0 # px, the width that alpha is meant for
data(name) = work . "/" . name

if (figure eq "mapping") {
  set multiplot layout 1,2
  set xrange [-half:half]
  set xlabel "x of the grip (mm, to the right)"
  set ylabel "w in the frame (px)"
  plot width / 2.0 + width / (2 * half) * x with lines linetype 3 title "equation (1a)", \
       data("mapping.csv") using "x":(column("pointer_x") * width) with points linetype 1 title "pointer events"
  set xlabel "y of the grip (mm, upwards)"
  set ylabel "h in the frame (px)"
  plot height / 2.0 - height / (2 * half) * x with lines linetype 3 title "equation (1b)", \
       data("mapping.csv") using "y":(column("pointer_y") * height) with points linetype 1 title "pointer events"
  unset multiplot
}

if (figure eq "features" || figure eq "flow") {
  stats data("flow.csv") using "region_x" nooutput name "left"
  stats data("flow.csv") using "region_y" nooutput name "top"
  stats data("flow.csv") using "region_width" nooutput name "side"
  set palette gray
  unset colorbox
  set size ratio -1
  unset grid
  grey(which) = sprintf("'%s/twig/%s.grey' binary array=(%d,%d) format='%%uchar' center=(%g,%g) with image notitle", work, which, width, height, width / 2.0, height / 2.0)
}

if (figure eq "features") {
  set xrange [0:width]
  set yrange [height:0]
  set object 1 rectangle from left_min, top_min rto side_min, side_min front fillstyle empty border linecolor rgb "#E69F00" linewidth 2.5
  eval "plot " . grey("earlier") . ", data('flow.csv') using 'x':'y' with points linetype 1 title 'features', '' using (left_min + side_min / 2):(top_min + side_min / 2) every ::0::0 with points linetype 2 pointtype 7 title 'haptic interface point'"
}

if (figure eq "flow") {
  around = 6
  set xrange [left_min - around:left_min + side_min + around]
  set yrange [top_min + side_min + around:top_min - around]
  set multiplot layout 1,2
  set key outside top center
  eval "plot " . grey("earlier") . ", data('flow.csv') using 'x':'y' with points linetype 1 pointtype 3 pointsize 1.2 title 'earlier', '' using (column('x') + column('dx')):(column('y') + column('dy')) with points linetype 2 title 'later'"
  set grid
  plot data("flow.csv") using "x":"y":(column("dx")):(column("dy")) with vectors linetype 1 title "displacement"
  unset multiplot
}

if (figure eq "gain") {
  set xlabel "speed (px/s in a frame 352 px wide)"
  set ylabel "force (N)"
  speed = "sqrt(column('vx') ** 2 + column('vy') ** 2) * reference / width"
  force = "sqrt(column('fx') ** 2 + column('fy') ** 2)"
  set xrange [0:150]
  set yrange [0:1.05]
  set key top left inside vertical
  eval "plot 2 * f_max / pi * atan(alpha * x) with lines linetype 3 title 'equation (5)', data('linear/trace.csv') using (" . speed . "):(" . force . ") every 3 with points linetype 2 pointsize 0.6 title 'felt: linear', data('twig/trace.csv') using (" . speed . "):(" . force . ") every 3 with points linetype 1 pointsize 0.5 title 'felt: arctan'"
}

if (figure eq "trace") {
  set xzeroaxis linetype -1 linecolor rgb "#444444"
  set lmargin 10
  set multiplot layout 2,1
  set ylabel "velocity (px/s)"
  plot data("twig/trace.csv") using "time":"vx" with lines linetype 1 title "to the right", \
       "" using "time":(-column("vy")) with lines linetype 2 title "upwards"
  set ylabel "force (N)"
  set xlabel "time (s)"
  plot data("twig/trace.csv") using "time":"fx" with lines linetype 1 title "to the right", \
       "" using "time":"fy" with lines linetype 2 title "upwards"
  unset multiplot
}
