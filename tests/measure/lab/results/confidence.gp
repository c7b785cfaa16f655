# SPDX-License-Identifier: LGPL-2.1-or-later
# Calibration and ROC curve of the confidence, and the time of each kind of scene.
#
#   gnuplot -c confidence.gp FOLDER CHART.png    (FOLDER contains reliability.csv, roc.csv and streams.csv)
if (ARGC != 2) { print "usage: gnuplot -c confidence.gp FOLDER CHART.png"; exit status 1 }
load system("dirname '" . ARG0 . "'") . "/style.gp"

eval(terminal(ARG2, 1500, 620))
set datafile missing NaN
methods = "'fast' 'method=opencv' 'PyrLK crop back' 'phase correlation' 'ECC'"
of(method, value) = strcol("method") eq method ? value : NaN
number(method) = group(method)
# The bins of a method with at least five cases; a line ends where there is none.
bins(method) = sprintf("< awk -F, -v method='\"%s\"' 'NR == 1 { print } $1 == method && $3 >= 5 { if (before && $2 - before > 0.15) print \"\"; before = $2; print }' '%s/reliability.csv'", method, ARG1)

set multiplot layout 1, 3 margins 0.07, 0.985, 0.25, 0.92 spacing 0.085, 0
set yrange [0:1]
set xrange [0:1]
set title "Calibration: error at most 0.3 px"
set xlabel "confidence"
set ylabel "share that is good, 95 % interval"
unset key # the middle panel has it
plot for [m = 5:1:-1] bins(word(methods, m)) using "confidence":"good" with linespoints \
  pointtype symbol[number(word(methods, m))] linecolor rgb colour[number(word(methods, m))] linewidth (m == 1 ? 2.5 : 1.2), \
  bins("fast") using "confidence":"good":"good_low":"good_high" with yerrorbars pointtype 7 linewidth 1.5 linecolor rgb colour[1], \
  x with lines dashtype 2 linecolor rgb "#777777"

set title "ROC: errors above 0.3 px"
set xlabel "good answers rejected"
set ylabel "bad answers rejected"
set key on inside bottom right vertical
plot for [m = 5:1:-1] ARG1 . "/roc.csv" using (of(word(methods, m), column("false_alarms"))):(column("detections")) \
  with lines linecolor rgb colour[number(word(methods, m))] linewidth (m == 1 ? 2.5 : 1.2) title word(methods, m), \
  x with lines dashtype 2 linecolor rgb "#777777" title "guessing"

set title "Time of the default by scene"
set xlabel ""
set ylabel "µs (median, whisker: p99)"
unset key
set autoscale
set logscale y
set yrange [0.1:*]
set xrange [*:*]
set offsets 0.6, 0.6, 0, 0
set xtics rotate by -35
plot ARG1 . "/streams.csv" using 0:(column("us_p50")):(column("us_p50")):(column("us_p99")):xticlabels(strcol("scene")) \
  with yerrorbars pointtype 7 pointsize 1.6 linewidth 1.5 linecolor rgb colour[1]
unset multiplot
