#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs the lab: speed against accuracy of the trackers and their peers, twelve minutes on two
# processors. Builds (release) in build-lab/, measures, draws the charts. The exit status is 0 only
# when no configuration of a peer dominates method=fast.
#
# Usage: tests/measure/lab/run.sh [--quick] [--ablation] [--pairs FOLDER] [--clips FOLDER] [--output FOLDER]
#   --quick          a minute, and few cases: to see whether all works, not to be believed
#   --ablation       only what each part of method=fast is worth: prints ablation.md, leaves docs/ alone
#   --pairs FOLDER   pairs of pictures with true flow, NAME_gt.flo beside NAME*.png or the layout of
#                    KITTI; without it the tables of pairs are left out
#   --clips FOLDER   videos; without it the tables of clips are left out
#   --output FOLDER  where tables and charts go. Without it they go to build-lab/results/, and the
#                    charts and the results page are copied to docs/

source "$(dirname "$0")/../../../pipelines/shared/common.sh"
source "$(dirname "$0")/../../packages.sh"
here=$root/tests/measure/lab

# Absolute, since the lab may be started from any folder.
folder() {
  [ -d "$1" ] || fail "there is no folder '$1'; check the name"
  (cd "$1" && pwd)
}

options=() ablation='' pairs='' clips='' output=''
while [ $# -gt 0 ]; do
  case $1 in
  --quick) options+=(--quick) && shift && continue ;;
  --ablation) options+=(--ablation) && ablation=yes && shift && continue ;;
  --help | -h) show_help && exit ;;
  --pairs | --clips | --output) [ $# -gt 1 ] || fail "$1 needs a folder; see --help" ;;
  *) fail "unknown option '$1'; see --help" ;;
  esac
  case $1 in
  --pairs) pairs=$(folder "$2") ;;
  --clips) clips=$(folder "$2") ;;
  --output) mkdir -p "$2" && output=$(folder "$2") ;;
  esac
  shift 2
done

if [ -z "${FEELING_WIND_BUILD:-}" ]; then
  install_packages "${run_packages[@]}" "${build_packages[@]}" "${test_packages[@]}" "${lab_packages[@]}"
  build=$root/build-lab
  echo "Building in $build ..."
  mkdir -p "$build"
  if { [ -f "$build/build.ninja" ] ||
    meson setup "$build" "$root" --buildtype=release -Dtests=enabled -Dbenchmarks=enabled -Ddevice=disabled; } \
    >"$build/build.log" 2>&1 && ninja -C "$build" tests/measure/lab/lab >>"$build/build.log" 2>&1; then
    :
  else
    tail -n 40 "$build/build.log" >&2
    fail "the lab could not be built; read the log $build/build.log"
  fi
fi
[ -x "$build/tests/measure/lab/lab" ] || fail "there is no '$build/tests/measure/lab/lab'; run: meson configure $build -Dbenchmarks=enabled, then build again"

results=${output:-$root/build-lab/results}
commit=$(git -C "$root" describe --always --dirty 2>/dev/null) || commit=unknown
status=0
"$build/tests/measure/lab/lab" ${options[@]+"${options[@]}"} ${pairs:+--pairs "$pairs"} ${clips:+--clips "$clips"} \
  --commit "$commit" --output "$results" || status=$?
[ "$status" -le 1 ] || exit "$status"

if [ "$ablation" ]; then
  cat "$results/ablation.md"
  exit
fi
for chart in pareto series confidence; do
  gnuplot -c "$here/results/$chart.gp" "$results" "$results/$chart.png"
done
if [ -z "$output" ]; then
  cp "$results"/{pareto,series,confidence}.png "$root/docs/images/lab/"
  cp "$results/results.md" "$root/docs/lab-results.md"
fi
echo "Tables and charts are in $results"
exit "$status"
