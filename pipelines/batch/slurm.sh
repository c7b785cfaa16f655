#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# One chunk of a plan as a job of an array for Slurm, and the merge after all. Slurm counts from 0, as the plan does:
#
#   haptic-track author --plan FILE... > plan.json
#   chunks=$(sbatch --parsable --array=0-$(($(grep -c '"first-span"' plan.json) - 1)) pipelines/batch/slurm.sh plan.json)
#   sbatch --dependency=afterok:$chunks pipelines/batch/slurm.sh --merge plan.json
#
# Usage: pipelines/batch/slurm.sh [--merge] PLAN
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --requeue

# Slurm runs a copy of this file from elsewhere. HAPTIC_TRACK names the program if it is not installed.
set -euo pipefail
if [ "${1:-}" = --merge ] && [ $# = 2 ]; then
  exec "${HAPTIC_TRACK:-haptic-track}" author --merge "$2"
fi
if [ $# != 1 ] || [ -z "${SLURM_ARRAY_TASK_ID:-}" ]; then
  echo "slurm.sh: start it with sbatch --array=0-LAST and a plan; its first lines say how" >&2
  exit 1
fi
exec "${HAPTIC_TRACK:-haptic-track}" author --chunk "$SLURM_ARRAY_TASK_ID" "$1"
