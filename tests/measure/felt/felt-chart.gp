# SPDX-License-Identifier: LGPL-2.1-or-later
# What a hand tells from the true motion against the time of a frame: a panel for each group of films, a line for each
# method, from alpha 0.01 to 0.04 s/px.
#
#   gnuplot -c felt-chart.gp TABLE.csv CHART.png    (TABLE.csv is the output of felt.sh)
if (ARGC != 2) { print "usage: gnuplot -c felt-chart.gp TABLE.csv CHART.png"; exit status 1 }
load system("dirname '" . ARG0 . "'") . "/../lab/results/style.gp"
unset datafile
set datafile separator ","

# `values(WHICH)` prints each different value of a column.
values(which) = system(sprintf("tail -n +2 '%s' | cut -d, -f%d | sed 's/ /_/g' | awk '!seen[$0]++'", ARG1, which))
means(films, method) = sprintf("< awk -F, -v films='%s' -v method='%s' '\
  $1 == films && $3 == method && $6 > 0 { told[$4] += $5; us += $6; of[$4]++; rows++ }\
  END { for (alpha in told) print us / rows \",\" told[alpha] / of[alpha] }' '%s' | sort -t, -k2n", films, method, ARG1)
spaced(name) = system("echo '" . name . "' | tr _ ' '")

all = values(1)
methods = values(3)
shown(method) = method eq "layers" ? "roitracker" : method eq "fast" || method eq "opencv" ? "method=" . method : method
# The default has the colour of the lab's.
kind(method) = group(method eq "layers" ? "fast" : method eq "opencv" ? "method=opencv" : method)
paint(method) = method eq "fast" ? 0xDDAABB : colour[kind(method) == 0 ? 10 : kind(method)]
mark(method) = method eq "fast" ? 6 : symbol[kind(method) == 0 ? 10 : kind(method)]

across = 3
rows = (words(all) + across - 1) / across
eval(terminal(ARG2, 1400, 130 + 310 * rows))
set logscale x
set xrange [20:15000]
set xtics (100, 1000, 10000)
set yrange [0:100]
set format x "%g"
unset key
set multiplot layout rows, across margins 0.075, 0.985, 0.14, 0.955 spacing 0.045, 0.09
do for [n = 1:words(all)] {
  films = word(all, n)
  set title films
  set xlabel (n > across * (rows - 1) ? "time of a frame (µs)" : "")
  set ylabel (n % across == 1 ? "told from the truth (%)" : "")
  if (n == words(all)) {
    do for [m = 1:words(methods)] {
      method = spaced(word(methods, m))
      set label m shown(method) at screen 0.08 + 0.155 * (m - 1), 0.035 offset 1.5, 0 \
        point linecolor rgb paint(method) pointtype mark(method) pointsize 1.3
    }
  }
  plot for [method in methods] means(films, spaced(method)) using 1:2 with linespoints linecolor rgb paint(spaced(method)) \
    linewidth 2 pointtype mark(spaced(method)) pointsize (method eq "layers" ? 1.6 : 1.1)
}
unset multiplot
