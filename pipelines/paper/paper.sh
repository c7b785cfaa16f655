#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Draws the paper's figures 6 and 8 to 11 from a real video, a tree in the wind. docs/paper.md compares them with
# the paper. (Figure 12 needs people: haptic-study.sh.)
#
# The hand moves in a circle for figure 6 and rests on a twig for the others, which run
#   gst-launch-1.0 filesrc location=VIDEO ! decodebin ! videoconvert ! deinterlace ! videoflip video-direction=auto \
#       ! videorate rate=SPEED ! video/x-raw,format=GRAY8 \
#       ! roitracker method=opencv ! velocityavg average=mean ! hapticsink force-law=arctan log-location=trace.csv
#
# Usage: pipelines/paper/paper.sh [--video FILE] [--speed SPEED] [--hand HAND] [FOLDER]
#   FOLDER        folder of the figures (docs/images/paper)
#   --video FILE  another video than the tree
#   --speed SPEED playback speed (1; the tree's file shows 2.4 frames a second and is played 8 times as fast)
#   --hand HAND   motion of the grip, as hapticsink's sim-hand (default: on the twig of the tree)
#
# Example:
#   pipelines/paper/paper.sh --video in.mp4 figures
#
# Needs build/ configured with -Dtests=enabled.

source "$(dirname "$0")/../shared/common.sh"
source "$(dirname "$0")/../shared/packages.sh"

video='' speed='' hand=file:$root/pipelines/films/hands/tree-hand.csv
read_options 'video= speed= hand=' "$@"
output=${inputs[0]:-$root/docs/images/paper}
program=$build/pipelines/motion-log
[ -x "$program" ] ||
  fail "'$program' is not built; run: meson configure $build -Dtests=enabled && meson compile -C $build"
[ -n "$video" ] || { video=$(tree_video) && speed=${speed:-8}; }
speed=${speed:-1}
[[ $speed =~ ^[0-9]*\.?[0-9]+$ ]] || fail "--speed needs a number, not '$speed'"
use_elements
need_video "$video"
mkdir -p "$output" || fail "the folder '$output' cannot be made; give another"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# `measure NAME HAND LAW` runs the whole loop with the paper's methods and writes its logs to $work/NAME.
measure() {
  mkdir "$work/$1"
  "$program" "$work/$1" "${film[*]} ! videorate rate=$speed
    ! video/x-raw,format=GRAY8
    ! roitracker name=tracker method=opencv ! velocityavg average=mean
    ! hapticsink device=sim sim-hand=$(quoted "$2") force-law=$3 log-location=$(quoted "$work/$1/trace.csv")"
}

# Prints each pointer event with the grip's position at its time: x,y in mm, pointer 0..1.
join_pointers() {
  echo x,y,pointer_x,pointer_y
  awk -F, '
    FNR == 1 { file++; next }
    file == 1 { x[int($1 * 1000 + 0.5)] = $2 * 1000; y[int($1 * 1000 + 0.5)] = $3 * 1000; next }
    { t = int($1 * 1000 + 0.5); if (t in x) print x[t] "," y[t] "," $2 "," $3 }' "$1/trace.csv" "$1/pointers.csv"
}

# Prints speed and force of every third tick, and whether the force is kept below the law: it changes as fast as slew-rate
# lets it (20 mN in a tick), or within the last 0.1 s it was held or the confidence below 0.5, from which it fades in again.
gain_points() {
  echo speed,force,limited
  awk -F, -v width="$width" '
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    {
      fx = $at["fx"]; fy = $at["fy"]
      if ($at["hold"] != 0 || $at["confidence"] < 0.5) faded = $at["time"] + 0.1
      limited = $at["time"] < faded || sqrt((fx - before_x) ^ 2 + (fy - before_y) ^ 2) > 0.018
      before_x = fx; before_y = fy
      if (NR % 3 == 0) print sqrt($at["vx"] ^ 2 + $at["vy"] ^ 2) * 352 / width "," sqrt(fx ^ 2 + fy ^ 2) "," limited
    }' "$1/trace.csv"
}

echo "Measuring in ${video##*/}: the hand in a circle, on the twig, and on the twig with the linear law ..."
measure round circle:0.9,4 arctan &
measure twig "$hand" arctan &
measure linear "$hand" linear &
for _ in 1 2 3; do wait -n || fail "the video could not be measured; see the message above"; done

join_pointers "$work/round" >"$work/mapping.csv"
IFS=, read -r frame width height < <(tail -n 1 "$work/twig/pair.csv")
awk -F, -v frame="$frame" 'NR == 1 || $1 == frame' "$work/twig/patches.csv" >"$work/flow.csv"
for law in twig linear; do gain_points "$work/$law" >"$work/$law-gain.csv"; done
for figure in mapping features flow gain trace; do
  gnuplot -e "figure='$figure'; pipelines='$root/pipelines'; work='$work'; width=$width; height=$height" "$root/pipelines/paper/figures.gp" \
    >"$work/$figure.png" || fail "gnuplot could not draw $figure.png; install gnuplot-nox"
  mv "$work/$figure.png" "$output/$figure.png"
done

awk -F, -v frame="$frame" '
  NR > 1 { n++; length_ = sqrt($9 ^ 2 + $10 ^ 2); sum += length_; x += $9; y += $10; if (length_ > most) most = length_ }
  END {
    printf "Frame %d: %d features, displaced by %.2f px in the mean, %.2f px at most; their mean displacement is (%.2f, %.2f) px\n",
      frame, n, sum / n, most, x / n, y / n
  }' "$work/flow.csv"
awk -F, '
  NR > 1 { v = sqrt($5 ^ 2 + $6 ^ 2); f = sqrt($8 ^ 2 + $9 ^ 2); if (v > fastest) fastest = v; if (f > strongest) strongest = f }
  END { printf "Velocity at most %.0f px/s, force at most %.2f N\n", fastest, strongest }' "$work/twig/trace.csv"
echo "$output/"{mapping,features,flow,gain,trace}.png
