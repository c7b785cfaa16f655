# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws two pictures of docs/how-it-works.md; how-it-works.sh sets pipelines, work and folder. Velocity is orange, force blue.
load pipelines . "/shared/palette.gp"
set terminal svg size 640,360 dynamic font "DejaVu Sans,15" background "white"

alpha = 0.01 # s/px
f_max = 1.0  # N
set output folder . "/law.svg"
unset key
set xlabel "speed v under the hand (px/s)"
set ylabel "force F (N)"
set xrange [0:500]
set yrange [0:1.05]
set arrow 1 from 100,0 to 100,0.5 nohead linecolor rgb "#E69F00" linewidth 2
set arrow 2 from 100,0.5 to 0,0.5 linecolor rgb "#0072B2" linewidth 2
set label 1 "100 px/s give 0.5 N" at 115,0.48
set label 2 "F = 2/π · 1 N · atan(0.01 s/px · v)" at 230,0.62
plot 2 * f_max / pi * atan(alpha * x) with lines linetype 13
unset arrow
unset label
set datafile separator ","

set output folder . "/time.svg"
set xlabel "time (s)"
set ylabel "velocity to the right (px/s)" textcolor rgb "#A06A00"
set y2label "force to the right (N)" textcolor rgb "#0072B2"
set xrange [0.8:1.6]
set yrange [-100:100]
set y2range [-1:1]
set y2tics
set ytics nomirror
set xzeroaxis linetype -1 linecolor rgb "#444444"
set key outside top center horizontal
# A velocity holds for the middle of its interval.
plot work . "/velocities.csv" using (($1 - $2 / 2) / 1e9):3 with points linetype 11 pointtype 7 pointsize 0.6 title "velocity, one for each frame", \
     work . "/trace.csv" using "time":"fx" axes x1y2 with lines linetype 13 title "force, one for each ms"
