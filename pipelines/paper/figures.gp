# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws one of the paper's figures to standard output; paper.sh sets figure, pipelines, work, width and height.
load pipelines . "/shared/palette.gp"
set terminal pngcairo size 1100,620 font "DejaVu Sans,17" background "white"
set datafile separator ","
set datafile columnheaders

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
       data("mapping.csv") using "x":(column("pointer_x") * width) with points linetype 16 pointtype 6 pointsize 0.8 title "pointer events"
  set xlabel "y of the grip (mm, upwards)"
  set ylabel "h in the frame (px)"
  plot height / 2.0 - height / (2 * half) * x with lines linetype 3 title "equation (1b)", \
       data("mapping.csv") using "y":(column("pointer_y") * height) with points linetype 16 pointtype 6 pointsize 0.8 title "pointer events"
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
  set object 1 rectangle from left_min, top_min rto side_min, side_min front fillstyle empty border linecolor rgb "#000000" linewidth 2
  eval "plot " . grey("earlier") . ", data('flow.csv') using 'x':'y' with points linetype 11 pointtype 7 pointsize 0.8 title 'features', '' using (left_min + side_min / 2):(top_min + side_min / 2) every ::0::0 with points linetype 16 pointtype 7 title 'haptic interface point'"
}

if (figure eq "flow") {
  around = 6
  set xrange [left_min - around:left_min + side_min + around]
  set yrange [top_min + side_min + around:top_min - around]
  set multiplot layout 1,2
  set key outside top center
  eval "plot " . grey("earlier") . ", data('flow.csv') using 'x':'y' with points linetype 1 pointtype 3 pointsize 1.2 title 'earlier', '' using (column('x') + column('dx')):(column('y') + column('dy')) with points linetype 2 title 'later'"
  set grid
  plot data("flow.csv") using "x":"y":(column("dx")):(column("dy")) with vectors linetype 11 title "displacement"
  unset multiplot
}

if (figure eq "gain") {
  set xlabel "speed (px/s in a frame 352 px wide)"
  set ylabel "force (N)"
  set xrange [0:110]
  set yrange [0:1.05]
  set key top right inside vertical Left reverse samplen 2
  law(x) = 2 * f_max / pi * atan(alpha * x)
  points(law, limited) = sprintf("'%s/%s-gain.csv' using (column('limited') == %d ? column('speed') : NaN):'force' with points", work, law, limited)
  eval "plot " . points("linear", 1) . " linetype 3 pointsize 0.45 linecolor rgb '#B8B8B8' title 'limited, fading or not trusted', " . \
    points("twig", 1) . " linetype 3 pointsize 0.45 linecolor rgb '#B8B8B8' notitle, " . \
    points("linear", 0) . " linetype 2 pointtype 7 pointsize 0.6 title 'felt with the linear law', " . \
    points("twig", 0) . " linetype 13 linewidth 2.5 pointtype 7 pointsize 0.6 title 'felt with the arctangent', " . \
    "law(x) with lines linewidth 2 linecolor rgb '#000000' title 'equation (5)'"
}

if (figure eq "trace") {
  set xzeroaxis linetype -1 linecolor rgb "#444444"
  set xrange [0:*] noextend
  set y2range [0:1]
  set offsets 0, 0, 0.05, 0.05
  unmeasured = "data('twig/trace.csv') using 'time':(column('confidence') > 0 ? 0 : 1) axes x1y2 with fillsteps linecolor rgb '#E8E8E8'"
  set multiplot layout 2,1 margins 0.11, 0.98, 0.16, 0.92 spacing 0, 0.08
  set format x ""
  set ylabel "velocity (px/s)"
  eval "plot " . unmeasured . " title 'not measured', '' using 'time':'vx' with lines linetype 11 title 'to the right', '' using 'time':(-column('vy')) with lines linetype 12 title 'upwards'"
  unset key
  set format x "%g"
  set ylabel "force (N)"
  set xlabel "time (s)"
  eval "plot " . unmeasured . ", '' using 'time':'fx' with lines linetype 13, '' using 'time':'fy' with lines linetype 14"
  unset multiplot
}
