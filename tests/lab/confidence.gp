# SPDX-License-Identifier: LGPL-2.1-or-later
# Calibration and ROC curve of the confidence, and the time of each kind of scene.
#
#   gnuplot -c confidence.gp FOLDER CHART.png    (FOLDER contains reliability.csv, roc.csv and streams.csv)
if (ARGC != 2) { print "usage: gnuplot -c confidence.gp FOLDER CHART.png"; exit status 1 }
load system("dirname '" . ARG0 . "'") . "/style.gp"

eval(terminal(ARG2, 1500, 560))
set datafile missing NaN
methods = "'fast' 'method=opencv' 'PyrLK crop back' 'phase correlation' 'ECC'"
of(method, value) = strcol("method") eq method ? value : NaN
number(method) = group(method)
set style data linespoints

set multiplot layout 1, 3 margins 0.055, 0.985, 0.22, 0.92 spacing 0.075, 0
set yrange [0:1]
set xrange [0:1]
set title "Calibration: good answers (error at most 0.3 px)"
set xlabel "confidence"
set ylabel "share that is good, 95 % interval"
unset key # the middle panel has it
enough(value) = column("cases") >= 5 ? value : NaN
plot for [m = 5:1:-1] ARG1 . "/reliability.csv" using (of(word(methods, m), enough(column("confidence")))):(column("good")) \
  pointtype symbol[number(word(methods, m))] linecolor rgb colour[number(word(methods, m))] \
  linewidth (m == 1 ? 2.5 : 1.2) title word(methods, m), \
  ARG1 . "/reliability.csv" using (of("fast", enough(column("confidence")))):(column("good")):(column("good_low")):(column("good_high")) \
  with yerrorbars pointtype 0 linewidth 1.5 linecolor rgb colour[1] notitle, \
  x with lines dashtype 2 linecolor rgb "#777777" notitle
set title "ROC: errors above 0.3 px found by low confidence"
set xlabel "good answers rejected"
set ylabel "bad answers rejected"
set key on bottom right
plot for [m = 5:1:-1] ARG1 . "/roc.csv" using (of(word(methods, m), column("false_alarms"))):(column("detections")) \
  with lines linecolor rgb colour[number(word(methods, m))] linewidth (m == 1 ? 2.5 : 1.2) title word(methods, m), \
  x with lines dashtype 2 linecolor rgb "#777777" title "guessing"

set title "Time of the default by scene, in a stream"
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
