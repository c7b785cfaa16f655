# SPDX-License-Identifier: LGPL-2.1-or-later
# Speed against accuracy: one panel per stratum, one point per configuration.
#
#   gnuplot -c pareto.gp FOLDER CHART.png    (FOLDER contains sweep.csv)
if (ARGC != 2) { print "usage: gnuplot -c pareto.gp FOLDER CHART.png"; exit status 1 }
load system("dirname '" . ARG0 . "'") . "/style.gp"
table = ARG1 . "/sweep.csv"

strata = system("tail -n +2 '" . table . "' | cut -d, -f1 | tr -d '\"' | awk '!seen[$0]++' | tr '\\n' ' '")
heading(stratum) = stratum eq "translation" ? "Translation within ±3 px, noise 1.5" : \
  stratum eq "wide" ? "Translation within ±12 px" : \
  stratum eq "pairs" ? "Real pairs with true flow" : "Hard scenes, one by one in the table"

eval(terminal(ARG2, 1400, 1120))
set format x "%g"
set format y "%g"
set datafile missing NaN # lines continue at the next valid point
set xlabel "median time from luma to velocity (µs)"
set ylabel "mean end-point error (px per frame)"
set y2label "force error (mN)" textcolor rgb "#666666"
unset key

# where: the value in the rows of a stratum with one thread, else NaN. of: the same for one group.
where(stratum, value) = strcol("stratum") eq stratum && column("threads") == 1 && \
  group(strcol("method")) > 0 ? value : NaN
of(stratum, g, value) = where(stratum, group(strcol("method")) == g ? value : NaN)
force(error) = 2000 / pi * atan(0.3 * error)

set multiplot layout (words(strata) + 1) / 2, 2 margins 0.065, 0.935, 0.15, 0.96 spacing 0.13, 0.10
do for [n = 1:words(strata)] {
  stratum = word(strata, n)
  unset logscale
  set autoscale
  stats table using (where(stratum, column("error"))) nooutput
  low = STATS_min * 0.6
  high = STATS_max * 1.6
  set yrange [low:high]
  set y2range [low:high]
  # Force in mN at round values of the error axis.
  set logscale xy
  set logscale y2
  set xrange [1:10000]
  set y2tics ()
  do for [e in "0.005 0.01 0.02 0.05 0.1 0.2 0.5 1 2 5 10 20"] {
    if (real(e) > low && real(e) < high) {
      set y2tics add (sprintf("%.0f", force(real(e))) real(e)) textcolor rgb "#666666"
    }
  }
  set title heading(stratum)
  plot \
    for [g = 10:1:-1] table using (of(stratum, g, column("front") == 0 ? column("us_p50") : NaN)):(column("error")) \
      with points pointtype symbol[g] pointsize 0.5 linecolor rgb (0xA0000000 + colour[g]) notitle, \
    table using (where(stratum, column("front") == 1 ? column("us_p50") : NaN)):(column("error")) with steps linecolor rgb "#444444" linewidth 1.5 notitle, \
    for [g = 10:1:-1] table using (of(stratum, g, column("front") == 1 || column("default") == 1 ? column("us_p50") : NaN)):(column("error")):(column("us_p50")):(column("us_p99")):(column("error_low")):(column("error_high")) \
      with xyerrorbars pointtype symbol[g] pointsize 0.9 linecolor rgb colour[g] linewidth 1 notitle, \
    table using (of(stratum, 1, column("default") == 1 ? column("us_p50") : NaN)):(column("error")) \
      with points pointtype 3 pointsize 2.6 linewidth 2.5 linecolor rgb "#000000" notitle
}

# One key for all panels.
unset logscale; unset xlabel; unset ylabel; unset y2label; unset title; unset border; unset tics; unset y2tics; unset grid
set lmargin at screen 0.05; set rmargin at screen 0.95; set bmargin at screen 0.005; set tmargin at screen 0.09
set key center center horizontal maxcols 5 samplen 1 width -2
set xrange [0:1]; set yrange [0:1]
plot for [g = 1:10] NaN with points pointtype symbol[g] pointsize 1 linecolor rgb colour[g] title word(titles, g), \
  NaN with points pointtype 3 pointsize 2 linewidth 2.5 linecolor rgb "#000000" title "the default", \
  NaN with lines linecolor rgb "#444444" linewidth 1.5 title "front", \
  NaN with points pointtype 7 pointsize 0.5 linecolor rgb "#A0A0A0" title "dominated"
unset multiplot
