#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The lab runs from one command and writes every table and chart. No measured time is asserted.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
here=$(dirname "$0")

mkdir "$work/clips"
"$MAKE_CLIP" 640 360 30 2 leaf |
  gst-launch-1.0 -q fdsrc ! rawvideoparse format=gray8 width=640 height=360 framerate=30/1 \
    ! videoconvert ! x264enc tune=zerolatency speed-preset=veryfast bitrate=4000 ! h264parse ! mp4mux ! filesink "location=$work/clips/leaf.mp4"

status=0
"$here/run.sh" --quick --clips "$work/clips" --output "$work/out" || status=$?
[ "$status" -le 1 ] || { echo "NOT OK: the lab ended with status $status"; exit 1; }
for file in {pareto,series,confidence}.png {sweep,series,streams,reliability,roc,scenes,clips,fields,ablation,vectors}.csv \
  lab.json results.md ablation.md; do
  [ -s "$work/out/$file" ] || { echo "NOT OK: there is no $file"; exit 1; }
done
for row in '"translation","fast","default"' '"hard","DIS fast"' '"wide","PyrLK crop"'; do
  grep -q "^$row" "$work/out/sweep.csv" || { echo "NOT OK: sweep.csv lacks $row"; exit 1; }
done
for row in '"points","fast",4' '"points","PyrLK crop",64'; do
  grep -q "^$row," "$work/out/series.csv" || { echo "NOT OK: series.csv lacks $row"; exit 1; }
done
for row in '"votes","mixed"' '"strain","bent"'; do
  grep -q "^$row," "$work/out/ablation.csv" || { echo "NOT OK: ablation.csv lacks $row"; exit 1; }
done
grep -q '"motion vectors of H.264" : "left out' "$work/out/lab.json" ||
  grep -q '"leaf, 640×360","vectors of the decoder"' "$work/out/vectors.csv" ||
  { echo "NOT OK: vectors.csv lacks the clip"; exit 1; }
"$here/run.sh" --quick --ablation --output "$work/parts" >"$work/parts.md"
if ! grep -q '^|Votes|' "$work/parts.md" || [ -e "$work/parts/sweep.csv" ]; then
  echo "NOT OK: --ablation does not print the table of the parts alone"
  exit 1
fi
if "$here/run.sh" --quick --pairs "$work/nowhere" 2>"$work/error" || ! grep -q "no folder" "$work/error"; then
  echo "NOT OK: a folder that is not there gives no clear error"
  exit 1
fi
if "$here/run.sh" --quick --pairs "$work/out" --output "$work/other" 2>"$work/error" ||
  ! grep -q "there is no pair of frames" "$work/error"; then
  echo "NOT OK: a folder without pairs gives no clear error"
  exit 1
fi
echo "ok"
