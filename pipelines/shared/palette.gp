# SPDX-License-Identifier: LGPL-2.1-or-later
# What all charts share, those of haptic-track too. The colours of Okabe and Ito suit every kind of colour vision;
# widths differ too. 1: ours, or the first; 2: what it is compared with, or the surface that is touched; 3: the rest.
# None of these has a colour of a quantity.
set encoding utf8
set border 3 linecolor rgb "#444444"
set tics nomirror out
set grid linecolor rgb "#DDDDDD" linewidth 1
set linetype 1 linecolor rgb "#882255" linewidth 2.5 pointtype 7
set linetype 2 linecolor rgb "#009E73" linewidth 1.5 pointtype 6
set linetype 3 linecolor rgb "#999999" linewidth 1.5 pointtype 7
# Velocity is orange and force blue in every picture; to the right is solid, upwards dashed, towards the user dotted.
set linetype 11 linecolor rgb "#E69F00" linewidth 2
set linetype 12 linecolor rgb "#E69F00" linewidth 1.5 dashtype 2
set linetype 13 linecolor rgb "#0072B2" linewidth 2
set linetype 14 linecolor rgb "#0072B2" linewidth 1.5 dashtype 2
set linetype 15 linecolor rgb "#0072B2" linewidth 2.5 dashtype 3
set linetype 16 linecolor rgb "#000000" linewidth 1.5 # the hand
set style fill solid noborder
set key outside top right horizontal samplen 3
