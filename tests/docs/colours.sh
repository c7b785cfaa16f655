#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Only what shows a velocity or a force has the orange of the velocity and the blue of the force, in pictures, charts and
# on the page. Whoever adds a file here says that it shows one of them.
set -euo pipefail
cd "$(dirname "$0")/../.."
source tests/support/promise.sh
known="gst-plugins/track/tools/plot/track-plot.cpp
gst-plugins/vision/overlay/overlay-drawing.hpp
pipelines/paper/array-picture.gp
pipelines/paper/how-it-works.gp
pipelines/paper/moving-picture.sh
pipelines/paper/overlay-marks.gp
pipelines/shared/palette.gp
pipelines/web/page/array.js
pipelines/web/page/style.css
pipelines/web/player/drawing.js"
only_known() {
  diff <(echo "$known") <(grep -rliE --include='*.'{gp,sh,css,js,mjs,html,cpp,hpp,dot} '(#|0x|=)(ff)?(e69f00|0072b2|56b4e9)' \
    docs gst-plugins pipelines spidar tests/measure | LC_ALL=C sort)
}
promise "no other file has these colours" only_known
promise "the blue of the page is that of its force alone" test "$(grep -ciE '0072b2|56b4e9' pipelines/web/page/style.css)" = 2
