#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Motion fields for many videos, on several machines at once. The videos lie in folders that all machines see
# under the same names; the copies come beside them, as haptic-track author makes them.
#
#   haptic-track author --jobs 1 FILE          is what runs for each, on one core
#
# With GNU parallel, which keeps a process running on each core of each machine:
#
#   pipelines/author-cluster.sh --machines :,wind,8/sea FILE...
#
# As an array of jobs for Slurm, one for each line of a list of files:
#
#   sbatch --array=1-$(wc -l <LIST) --cpus-per-task=1 --wrap='pipelines/author-cluster.sh --list LIST'
#
# Usage: pipelines/author-cluster.sh [--machines LOGIN,...] [--output FOLDER] FILE...
#        pipelines/author-cluster.sh [--output FOLDER] --list LIST
#   --machines  as parallel's --sshlogin: names of machines, N/NAME for N processes there; : is this one, and all
#               there is unless named
#   --list      the file in the line $SLURM_ARRAY_TASK_ID of this list
#   --output    folder of the copies; otherwise that of each video
# Run again, it goes on where it was stopped. The exit status is 0 if all copies are there.

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
[ -x "$author" ] || author=$(command -v haptic-track) || fail "haptic-track is neither built nor installed"

if [ -n "$list" ]; then
  [ $# -eq 0 ] || fail "the files are in the list; see --help"
  need_file "$list"
  [[ ${SLURM_ARRAY_TASK_ID:-} =~ ^[1-9][0-9]*$ ]] ||
    fail "SLURM_ARRAY_TASK_ID does not say which line of '$list'; it is started by sbatch --array, see --help"
  file=$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$list")
  [ -n "$file" ] || fail "'$list' has no line $SLURM_ARRAY_TASK_ID"
  exec "$author" author --jobs 1 "${output[@]}" -- "$file"
fi

[ $# -gt 0 ] || fail "which videos? See --help"
command -v parallel >/dev/null || fail "GNU parallel is not installed (package parallel)"
exec parallel --will-cite --sshlogin "$machines" --env GST_PLUGIN_PATH --env GST_REGISTRY --workdir "$PWD" \
  --line-buffer "$author" author --jobs 1 "${output[@]}" -- {} ::: "$@"
