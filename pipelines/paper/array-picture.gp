# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws the amplitude of each actuator over time. Called by array-picture.sh, which sets amplitudes, channels and out.
set terminal pngcairo size 1200,560 font "DejaVu Sans,17" background "white"
set output out
unset key
unset grid
set yrange [channels + 0.5:0.5]
set ytics 1
set xrange [0:*] noextend
set cbrange [0:*]
set palette defined (0 "#FFFFFF", 1 "#0072B2")
set xlabel "time (s)"
set ylabel "actuator"
set cblabel "amplitude (of full scale)"
plot amplitudes using 1:2:3 with image
