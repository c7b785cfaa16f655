#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Authors motion fields for many videos on several machines. All machines must see the videos under the same
# names. For each video it runs, on one core,
#
#   haptic-track author --jobs 1 FILE
#
# With GNU parallel, one process on each core of each machine:
#
#   pipelines/author-cluster.sh --machines :,wind,8/sea FILE...
#
# As an array of jobs for Slurm, one for each line of a list of files:
#
#   sbatch --array=1-$(wc -l <LIST) --cpus-per-task=1 --wrap='pipelines/author-cluster.sh --list LIST'
#
# Usage: pipelines/author-cluster.sh [--machines LOGIN,...] [--output FOLDER] FILE...
#        pipelines/author-cluster.sh [--output FOLDER] --list LIST
#   --machines  as parallel's --sshlogin: names of machines, N/NAME for N processes there; : is this machine
#               (default)
#   --list      the video is in line $SLURM_ARRAY_TASK_ID of this file
#   --output    folder of the copies (default: that of each video)
# A second run continues where the first was stopped. The exit status is 0 if all copies exist.

source "$(dirname "$0")/common.sh"

machines=: list='' output=()
while [ $# -gt 0 ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --machines | --list | --output)
    [ -n "${2:-}" ] || fail "$1 needs a value; see --help"
    case $1 in
    --machines) machines=$2 ;;
    --list) list=$2 ;;
    --output) output=(--output "$2") ;;
    esac
    shift 2
    ;;
  -*) fail "unknown option '$1'; see --help" ;;
  *) break ;;
  esac
done

use_elements motionfield hapticconvert
author=$build/gst-plugins/track/tools/haptic-track
[ -x "$author" ] || author=$(command -v haptic-track) || fail "haptic-track is neither built nor installed; run ./pipelines/demo.sh"

if [ -n "$list" ]; then
  [ $# -eq 0 ] || fail "give either --list or files, not both; see --help"
  need_file "$list"
  [[ ${SLURM_ARRAY_TASK_ID:-} =~ ^[1-9][0-9]*$ ]] ||
    fail "SLURM_ARRAY_TASK_ID does not say which line of '$list'; start it with sbatch --array, see --help"
  file=$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$list")
  [ -n "$file" ] || fail "'$list' has no line $SLURM_ARRAY_TASK_ID; use sbatch --array=1-$(wc -l <"$list")"
  exec "$author" author --jobs 1 "${output[@]}" -- "$file"
fi

[ $# -gt 0 ] || fail "which videos? See --help"
command -v parallel >/dev/null || fail "GNU parallel is not installed; as root run: apt-get install parallel"
exec parallel --will-cite --sshlogin "$machines" --env GST_PLUGIN_PATH --env GST_REGISTRY --workdir "$PWD" \
  --line-buffer "$author" author --jobs 1 "${output[@]}" -- {} ::: "$@"
