#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Authors motion fields for videos with GNU parallel: a plan, its chunks in any order, one process on each core of each
# machine, and their merge. All machines must see the folders under the same names.
#
# Usage: pipelines/batch/parallel.sh [--machines LOGIN,...] [--output FOLDER] [--chunks N] FILE...
#   --machines  names of machines, separated by commas. N/NAME runs N processes there, and : is this machine
#               (default: :)
#   --output    folder of the copies (default: that of each video)
#   --chunks    about this number of chunks (default: one for each minute)
# The plan is plan.json in the folder where you stand. A second run continues where the first was stopped. The exit
# status is 0 if all copies exist.
#
# Example:
#   pipelines/batch/parallel.sh --machines :,4/other --output authored a.mp4 b.mp4

source "$(dirname "$0")/../shared/common.sh"

machines=: output='' chunks=''
read_options 'machines= output= chunks=' "$@"
[ ${#inputs[@]} -gt 0 ] || fail "there is no video to author; name some, see --help"
command -v parallel >/dev/null || fail "GNU parallel is not installed; as root run: apt-get install parallel"
use_elements motionfield hapticconvert
program=$build/gst-plugins/track/tools/haptic-track
[ -x "$program" ] || program=$(command -v haptic-track) || fail "haptic-track is neither built nor installed; run ./pipelines/demo.sh"

# What cannot be authored is said and not in the plan. The rest goes on.
status=0
"$program" author --plan ${output:+--output "$output"} ${chunks:+--chunks "$chunks"} -- \
  "${inputs[@]}" >plan.json || status=1
[ -s plan.json ] || exit 1
seq 0 $(($(grep -c '"first-span"' plan.json) - 1)) |
  parallel --will-cite --quote --sshlogin "$machines" --env GST_PLUGIN_PATH --env GST_REGISTRY --workdir "$PWD" \
    --line-buffer "$program" author --chunk {} plan.json || status=1
"$program" author --merge plan.json || status=1
exit $status
