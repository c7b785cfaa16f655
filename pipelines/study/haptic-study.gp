# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws the weighted average values of haptic-study.sh as the paper's figure 12.
#
#   gnuplot -c haptic-study.gp TABLE.csv PLOT.png
if (ARGC != 2) { print "usage: gnuplot -c haptic-study.gp TABLE.csv PLOT.png"; exit status 1 }

load system("dirname '" . ARG0 . "'") . "/../shared/palette.gp"
set terminal pngcairo size 900,600 font "DejaVu Sans,15" background "white"
set output ARG2
set datafile separator ","
set grid noxtics
set boxwidth 0.36
set xrange [-0.6:2.6]
set yrange [0:5.9]
set ytics ("1 Bad" 1, "2 Poor" 2, "3 Average" 3, "4 Good" 4, "5 Very good" 5)
set xtics ("Interactivity" 0, "Sensitivity" 1, "Reality" 2) scale 0
set ylabel "weighted average value"
at(aspect) = aspect eq "interactivity" ? 0 : aspect eq "sensitivity" ? 1 : 2
is(word, column) = strcol(column) eq word

plot ARG1 using (is("without", 2) ? at(strcol(1)) - 0.2 : NaN):"WAV" with boxes linetype 3 title "without force", \
     "" using (is("with", 2) ? at(strcol(1)) + 0.2 : NaN):"WAV" with boxes linetype 13 title "with force", \
     "" using (at(strcol(1)) + (is("with", 2) ? 0.2 : -0.2)):9:(sprintf("%s\nn = %s", strcol(9), strcol(3))) every ::1 with labels offset 0,1.7 notitle
