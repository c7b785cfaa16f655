# SPDX-License-Identifier: LGPL-2.1-or-later
# Speed against accuracy: one panel per stratum, one point per configuration.
#
#   gnuplot -c pareto.gp FOLDER CHART.png    (FOLDER contains sweep.csv)
if (ARGC != 2) { print "usage: gnuplot -c pareto.gp FOLDER CHART.png"; exit status 1 }
here = system("dirname '" . ARG0 . "'")
load here . "/style.gp"
table = ARG1 . "/sweep.csv"

strata = system("tail -n +2 '" . table . "' | cut -d, -f1 | tr -d '\"' | awk '!seen[$0]++' | tr '\\n' ' '")
heading(stratum) = stratum eq "translation" ? "Translation within ±3 px, noise 1.5" : \
  stratum eq "wide" ? "Translation within ±12 px" : \
  stratum eq "pairs" ? "Real pairs with true flow" : "Hard scenes, one by one in the table"

eval(terminal(ARG2, 1400, 1240))
set format x "%g"
set format y "%g"
unset key
set style textbox opaque noborder margins 0.5, 0.2
ours = colour[1]
peers = colour[3]
reference = colour[2]

where(stratum, value) = strcol("stratum") eq stratum && column("threads") == 1 && group(strcol("method")) > 0 ? value : NaN
front(stratum, who) = sprintf("< awk -f '%s/pareto.awk' -v stratum=%s -v peers=%d '%s'", here, stratum, who, table)
force(error) = 2000 / pi * atan(0.3 * error)

set multiplot layout (words(strata) + 1) / 2, 2 margins 0.085, 0.915, 0.13, 0.965 spacing 0.11, 0.08
do for [n = 1:words(strata)] {
  stratum = word(strata, n)
  unset logscale
  set autoscale
  stats table using (where(stratum, column("error"))) nooutput
  low = STATS_min * 0.5
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
  # Axes have names at the left, at the right and below.
  set xlabel (n > words(strata) - 2 ? "median time from luma to velocity (µs)" : "")
  set ylabel (n % 2 == 1 ? "mean error (px per frame)" : "")
  set y2label (n % 2 == 0 ? "force error (mN)" : "") textcolor rgb "#666666"
  set title heading(stratum)
  set arrow 1 from graph 0.10, 0.12 to graph 0.02, 0.02 linecolor rgb "#666666" linewidth 2
  set label 1 "better" at graph 0.02, 0.15 textcolor rgb "#666666"
  plot \
    table using (where(stratum, column("peer") == 1 ? column("us_p50") : NaN)):(column("error")) \
      with points pointtype 7 pointsize 0.4 linecolor rgb "#D0D0D0", \
    table using (where(stratum, strcol("method") eq "fast" ? column("us_p50") : NaN)):(column("error")) \
      with points pointtype 7 pointsize 0.4 linecolor rgb (0x90000000 + ours), \
    for [who = 0:1] front(stratum, who) using 1:2 with steps linecolor rgb (who ? peers : ours) linewidth 1.5, \
    for [who = 0:1] front(stratum, who) using 1:2:1:5:3:4 with xyerrorbars pointtype 7 pointsize 0.8 linewidth 1 \
      linecolor rgb (0x80000000 + (who ? peers : ours)), \
    front(stratum, 1) using 1:2:6 with labels left boxed offset 0.8, 0.8 textcolor rgb peers, \
    table using (where(stratum, strcol("method") eq "method=opencv" && column("default") == 1 ? column("us_p50") : NaN)):(column("error")):("method=opencv") \
      with labels left boxed offset 0.8, 0.8 textcolor rgb reference point pointtype 5 pointsize 1 linecolor rgb reference, \
    table using (where(stratum, strcol("method") eq "fast" && column("default") == 1 ? column("us_p50") : NaN)):(column("error")):("default") \
      with labels center boxed offset 0, 1.3 textcolor rgb ours point pointtype 3 pointsize 2.6 linewidth 2.5 linecolor rgb "#000000"
}

# One key for all panels.
unset logscale; unset xlabel; unset ylabel; unset y2label; unset title; unset border; unset tics; unset y2tics; unset grid
unset arrow; unset label
set lmargin at screen 0.02; set rmargin at screen 0.98; set bmargin at screen 0.005; set tmargin at screen 0.07
set key center center horizontal maxrows 2 samplen 2 width 1
set xrange [0:1]; set yrange [0:1]
plot NaN with linespoints pointtype 7 linecolor rgb ours linewidth 1.5 title "method=fast, not beaten by itself", \
  NaN with points pointtype 3 pointsize 2 linewidth 2.5 linecolor rgb "#000000" title "its default", \
  NaN with linespoints pointtype 7 linecolor rgb peers linewidth 1.5 title "peers, not beaten by a peer", \
  NaN with points pointtype 7 pointsize 0.6 linecolor rgb "#C0C0C0" title "other settings of peers"
unset multiplot
