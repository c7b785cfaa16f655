# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034 # its variables are read by the scripts that source it
# What the scripts share that draw pictures over the film of the demonstration. To be sourced with the arguments of the
# script: the folder of the pictures is $folder, the film $video, and $work a scratch folder that goes away.

source "$(dirname "${BASH_SOURCE[0]}")/../shared/common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../shared/packages.sh"

case ${1:---help} in
--help | -h) show_help && exit ;;
-*) fail "unknown option '$1'; see --help" ;;
esac
folder=$1
[ -d "$folder" ] || fail "there is no folder '$folder'; make it, or give another"
for program in ffmpeg gnuplot; do
  command -v $program >/dev/null || fail "$program is not installed; as root run: apt-get install ffmpeg gnuplot-nox"
done
use_elements roitracker hapticoverlay velocityavg hapticsink
need_packaged_elements y4mdec
video=$(wind_film)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
