#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The judge of hold.sh follows the points of a film, a file of TAP-Vid, and a clip there and back.
#
# Usage: hold-test.sh HOLD-RUN WIND-FILM

source "$(dirname "$0")/../../../pipelines/shared/common.sh"
source "$(dirname "$0")/../../support/promise.sh"
here=$(dirname "$0") run=$1 program=$2
find_plugins
/usr/bin/python3 -c 'import numpy' 2>/dev/null || skip "Python has no numpy (package python3-numpy)"
gst-inspect-1.0 --exists x264enc || skip "x264enc is not installed (package gstreamer1.0-plugins-ugly)"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

judge() {
  "$here/judge-hold.py" --run "$run" "$@" >"$work/table" || return
  cat "$work/table"
}
# `row NAME COLUMN LEAST`: a figure of the table.
row() {
  awk -F ' *[|] *' -v name="$1" -v column="$2" -v least="$3" '$2 == name { ok = $(column + 1) >= least } END { exit !ok }' "$work/table"
}
fails_with() { fails_with_status 1 "$@"; }
fails_with_status() {
  local wanted=$1 text=$2 status=0
  shift 2
  "$here/judge-hold.py" --run "$run" "$@" >"$work/said" 2>&1 || status=$?
  cat "$work/said"
  [ "$status" = "$wanted" ] && grep -q -- "$text" "$work/said"
}

promise "a film with points is made" "$program" --width 640 --height 360 --rate 30 --duration 1 --quality 10 \
  --points "$work/wind.csv" "$work/wind.mkv"
promise "PyrLK follows its points" judge --tracker lk "$work/wind.mkv"
promise "most of a branch for a second" row branch 3 60
promise "better than the flag" test "$(awk -F '|' '/branch/ { print $4 }' "$work/table")" -gt "$(awk -F '|' '/flag/ { print $4 }' "$work/table")"
promise "and the table has a row for all" row '**all**' 2 150
promise "a peer has one row" judge --tracker lk --every 5 --all-only "$work/wind.mkv"
promise "of every fifth point" row lk 2 40

# A still picture of noise, and a point on it that hides in the second frame.
/usr/bin/python3 - "$work/davis.pkl" "$work/stacking.pkl" <<'END'
import pickle, sys
import numpy
picture = numpy.random.default_rng(1).integers(0, 255, (72, 128, 3), numpy.uint8)
video = numpy.stack([picture] * 5)
places = numpy.full((1, 5, 2), 0.5)
occluded = numpy.array([[False, True, False, False, False]])
noise = {"video": video, "points": places, "occluded": occluded}
pickle.dump({"noise": noise}, open(sys.argv[1], "wb"))
pickle.dump([noise], open(sys.argv[2], "wb"))
END
promise "a file of RGB-Stacking, whose videos have no names, is judged" judge --tracker lk --tap-vid "$work/stacking.pkl"
promise "by their numbers" row 0 3 100
promise "a file of TAP-Vid is judged" judge --tracker lk --tap-vid "$work/davis.pkl"
promise "each video" row noise 3 100
promise "and the mean of all" row '**mean of the videos**' 5 100
promise "to show it while it is hidden costs a quarter of the Jaccard" row noise 4 75
promise "but not more" test "$(awk -F '|' '/noise/ { print $5 + 0 }' "$work/table")" = 75

"$program" --width 640 --height 360 --rate 30 --duration 2.2 "$work/clip.mkv"
promise "a clip is followed there and back" judge --tracker lk --round-trip "$work/clip.mkv"
promise "at many places" row clip.mkv 2 5
promise "of which all are taken" row clip.mkv 3 100

promise "no step is refused" fails_with_status 2 "--every is 1 or more" --every 0 "$work/wind.mkv"
promise "a tracker that is not there is refused" fails_with "see above" --tracker other "$work/wind.mkv"
cp "$work/wind.csv" "$work/cut.csv"
head -c "$(($(stat -c %s "$work/wind.mkv") * 2 / 5))" "$work/wind.mkv" >"$work/cut.mkv"
promise "a film that ends early" fails_with "cut.mkv ends after" --tracker lk "$work/cut.mkv"
promise "a film without points too" fails_with "clip.csv" --tracker lk "$work/clip.mkv"
