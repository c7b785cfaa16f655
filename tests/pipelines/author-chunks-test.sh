#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# haptic-track author in chunks: the same bytes however a film is divided, in any order, after any stop; and what is said
# where a chunk, a plan or a film is not what it was. Under GNU parallel, Snakemake and Slurm.

source "$(dirname "$0")/support.sh"

haptic_track=$build/gst-plugins/track/tools/haptic-track
use_elements motionfield hapticconvert
for element in x264enc avdec_h264; do
  gst-inspect-1.0 --exists "$element" || skip "there is no element $element"
done
cd "$work"

author() { "$haptic_track" author "$@"; }
# `says STATUS TEXT COMMAND...`
says() {
  local status=0 wanted=$1 text=$2
  shift 2
  "$@" >"$work/output" 2>&1 || status=$?
  cat "$work/output"
  [ "$status" = "$wanted" ] && grep -qF -- "$text" "$work/output"
}
count() { grep -c '"first-span"' "$1"; }

# A film of 75 s: key frames 2 s apart, frames that are not decoded in their order, noise, and sound.
mkdir in one out
"$MAKE_CLIP" 96 64 5 75 halves:0,-20,0,20 >film.gray
ffmpeg -v error -f rawvideo -pix_fmt gray -s 96x64 -r 5 -i film.gray -f lavfi -i sine -shortest -vf noise=alls=8:allf=t \
  -c:v libx264 -x264-params keyint=10:bframes=2:open-gop=1 -pix_fmt yuv420p -c:a aac in/film.mp4
promise "one process authors a film" author --output one in/film.mp4

# `merged FOLDER CHUNKS [OPTION]...`: so many, in an order that changes, and their merge.
merged() {
  local folder=$1 chunks=$2
  shift 2
  rm -rf out && mkdir out
  author --plan --chunks "$chunks" --output out "$@" in/film.mp4 >plan.json || return 1
  for chunk in $(seq 0 $(($(count plan.json) - 1)) | sort -R --random-source=in/film.mp4); do
    author --chunk "$chunk" plan.json || return 1
  done
  author --merge plan.json && cmp "$folder/film.haptic.ts" out/film.haptic.ts
}
hold=(--hold auto --hold "0.25,0.5@33")
mkdir held
promise "and with things to hold" author --output held "${hold[@]}" in/film.mp4
promise "which it has" test "$("$haptic_track" info held/film.haptic.ts | sed -n 's/^  things *//p')" -gt 8
promise "3 chunks give the same things" merged held 3 "${hold[@]}"
for chunks in 1 2 7 100; do
  promise "$chunks chunks give the same bytes" merged one "$chunks"
done
promise "so many as there are spans" test "$(count plan.json)" = 8
promise "nothing but copy and manifest remains" test "$(ls out)" = "$(printf 'film.haptic.ts\nplan.manifest.csv\nplan.manifest.json')"
promise "the table has a row for the copy" grep -qF "film.haptic.ts\",\"$(sha256sum <out/film.haptic.ts | cut -d ' ' -f 1)\"" out/plan.manifest.csv
cp out/plan.manifest.json before.json
promise "merged again, it stays" author --merge plan.json
promise "and so does the manifest" cmp before.json out/plan.manifest.json
sed '/"bytes"/d' before.json >out/plan.manifest.json
promise "a row that was changed does not count" says 1 'this chunk is missing, number 0' author --merge plan.json
cp before.json out/plan.manifest.json
promise "a chunk of it is not measured again" says 0 'there already: ' author --chunk 0 plan.json
promise "and leaves nothing behind" test "$(ls out)" = "$(printf 'film.haptic.ts\nplan.manifest.csv\nplan.manifest.json')"
cp out/film.haptic.ts whole.ts
printf 'x' | dd of=out/film.haptic.ts bs=1 seek=5000 conv=notrunc status=none
promise "one of a copy that was changed is" author --chunk 0 plan.json
promise "and is there" test -e out/film.haptic.chunk-0-1
rm out/film.haptic.chunk-0-1
cp whole.ts out/film.haptic.ts

# Stopped while it writes. A slow machine may see it only when it is over.
killed_while_it_writes() {
  local attempt status
  for attempt in {1..5}; do
    rm -f out/*.part out/*chunk-*
    "$haptic_track" author --chunk 1 plan.json &
    while kill -0 $! 2>/dev/null && ! compgen -G 'out/*.part' >/dev/null; do :; done
    kill -"$1" $! 2>/dev/null
    status=0
    wait $! || status=$?
    [ "$status" != 0 ] || continue
    [ -z "$(compgen -G 'out/*chunk-*[0-9]')" ]
    return
  done
  echo "it was over before it was seen, $attempt times"
  return 1
}
killed_and_again() {
  rm -rf out && mkdir out
  author --plan --chunks 2 --output out in/film.mp4 >plan.json || return 1
  killed_while_it_writes KILL && killed_while_it_writes TERM || return 1
  ! compgen -G 'out/*.part' || return 1 # after the second signal
  author --chunk 0 plan.json && author --chunk 1 plan.json && author --chunk 1 plan.json
}
promise "a chunk that was killed is made again" killed_and_again

# What is not as it should be.
promise "there is no chunk behind the last" says 1 'there is no chunk 2 in this plan, which has 2' author --chunk 2 plan.json
mv out/film.haptic.chunk-0-4 kept
promise "a lost chunk is named" says 1 'this chunk is missing, number 0' author --merge plan.json
cp out/film.haptic.chunk-4-8 out/film.haptic.chunk-0-4
promise "so is one with another's content" says 1 'belongs to another video or version' author --merge plan.json
head -c 2000 kept >out/film.haptic.chunk-0-4
promise "and one that is cut off" says 1 'this chunk is damaged, number 0' author --merge plan.json
promise "no copy was begun" test ! -e out/film.haptic.ts
promise "a damaged chunk is made again" author --chunk 0 plan.json
promise "to what it was" cmp kept out/film.haptic.chunk-0-4
sed 's/"version": "/&9/' plan.json >later.json
promise "what a merge would ignore is refused" says 1 "author --merge: Unknown option --columns" author --columns 8 --merge plan.json
promise "and what a plan would" says 1 "author --plan: Unknown option --jobs" author --jobs 2 --plan in/film.mp4
promise "and what info would" says 1 "info: Unknown option --force" "$haptic_track" info --force out/film.haptic.ts
promise "a plan of another version is refused" says 1 'version 9' author --merge later.json
sed 's/"end-span": 4/"end-span": 5/' plan.json >wrong.json
promise "so is a plan with a hole" says 1 'this is not a plan, or it was changed' author --merge wrong.json
promise "and what is none" says 1 'this is not a plan' author --chunk 0 before.json
cp in/film.mp4 same.mp4
touch in/film.mp4
promise "a film with another time and the same content is taken" author --chunk 0 plan.json
printf 'x' | dd of=in/film.mp4 bs=1 seek=5000 conv=notrunc status=none
promise "a film that was changed is refused" says 1 'has changed since the plan was made' author --chunk 1 plan.json
promise "and by the merge" says 1 'has changed since the plan was made' author --merge plan.json
cp same.mp4 in/film.mp4
promise "a full disk is said" says 1 'cannot be written' \
  bash -c "rm out/*chunk*; ulimit -f 8; '$haptic_track' author --chunk 0 plan.json"
promise "and leaves nothing" test "$(ls out)" = plan.manifest.csv"$(printf '\nplan.manifest.json')"
echo 'no video' >in/none.mp4
promise "what cannot be authored is said by the plan" says 1 'none.mp4"' author --plan --output out in/none.mp4 in/film.mp4
promise "the rest is in it" says 1 '"first-span"' author --plan --output out in/none.mp4 in/film.mp4
ffmpeg -v error -f lavfi -i testsrc2=size=96x64:rate=2:duration=630 -c:v libx264 -g 10000 -sc_threshold 0 -pix_fmt yuv420p in/sparse.mp4
promise "so is a film with one key frame in ten minutes" says 0 '630 s between two of its key frames' \
  bash -c "'$haptic_track' author --plan --chunks 7 --output out in/sparse.mp4 >sparse.json"
promise "which is one chunk" test "$(count sparse.json)" = 1
promise "it is measured" author --chunk 0 sparse.json
promise "and merged" author --merge sparse.json
promise "one process authors it too" author --output one in/sparse.mp4
promise "to the same bytes" cmp one/sparse.haptic.ts out/sparse.haptic.ts

sed 's/"columns": 0/"columns": 4294967297/' plan.json >wrong.json
promise "a plan with other columns than there are is refused" says 1 'this is not a plan' author --chunk 0 wrong.json
touch -d 1969-01-01 in/sparse.mp4
author --plan --output out in/sparse.mp4 >old.json
promise "a plan of a film that is older than 1970 is read" says 1 'there is no chunk 9 in this plan' author --chunk 9 old.json
cp in/sparse.mp4 $'in/f\xfcr.mp4'
promise "a name that no plan can hold is refused" says 1 'this name is not in UTF-8' \
  author --plan --output out $'in/f\xfcr.mp4'
rm $'in/f\xfcr.mp4'

# What was made of a film is known while the film is away.
mkdir pair made
cp in/sparse.mp4 pair/a.mp4
cp in/film.mp4 pair/b.mp4
author --plan --chunks 2 --output made pair/a.mp4 pair/b.mp4 >pair.json
author --chunk 0 pair.json >/dev/null
promise "the first of two films is merged without the second" says 1 'this chunk is missing' author --merge pair.json
mv pair/a.mp4 elsewhere.mp4
promise "then it is away" says 1 'a.mp4"' author --merge pair.json
mv elsewhere.mp4 pair/a.mp4
for ((chunk = 1; chunk < $(count pair.json); chunk++)); do author --chunk "$chunk" pair.json; done >/dev/null
promise "it is not measured again" author --merge pair.json

# Far more key frames are read than were measured.
ffmpeg -v error -f lavfi -i testsrc=size=64x48:rate=30:duration=40 -c:v libx264 -preset ultrafast -g 1 -pix_fmt yuv420p in/intra.mp4
promise "a film of key frames alone is authored" author --columns 4 --output one in/intra.mp4
promise "and gets key fields alone" says 0 "keys       1200" "$haptic_track" info one/intra.haptic.ts

# Engines.
export HAPTIC_TRACK=$haptic_track
# `by_engine NAME COMMAND...`
by_engine() {
  rm -rf out && mkdir out
  author --plan --chunks 3 --output out in/film.mp4 >plan.json
  "$@" && cmp one/film.haptic.ts out/film.haptic.ts
}
missing=()
if command -v parallel >/dev/null; then
  ln -s "$build" "$work/a build"
  promise "GNU parallel gives the same bytes, from a folder with a space in its name" \
    by_engine env FEELING_WIND_BUILD="$work/a build" "$root/pipelines/batch/parallel.sh" --chunks 3 --output out in/film.mp4
else
  missing+=("parallel is not installed")
fi
if command -v snakemake >/dev/null; then
  promise "Snakemake gives the same bytes" by_engine snakemake --quiet --cores 2 --snakefile "$root/pipelines/batch/Snakefile"
else
  missing+=("snakemake is not installed")
fi

# Slurm on one node, this machine, without systemd and without munge. Its daemons end with this script.
start_slurm() {
  local first
  first=$(free_ports 2)
  mkdir state spool
  export SLURM_CONF=$work/slurm.conf
  cat >slurm.conf <<END
ClusterName=test
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$first
SlurmdPort=$((first + 1))
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
ReturnToService=2
MpiDefault=none
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
END
  slurmctld -D >slurmctld.log 2>&1 &
  slurm=$!
  slurmd -D >slurmd.log 2>&1 &
  slurm+=" $!"
  # shellcheck disable=SC2064 # the processes of now
  trap "kill $slurm 2>/dev/null; wait; rm -rf '$work'" EXIT
  until timeout 10 sinfo -h -o %T 2>/dev/null | grep -qx idle; do
    # shellcheck disable=SC2086 # two processes
    kill -0 $slurm 2>/dev/null || return 1
  done
}
by_slurm() {
  local chunks script=$root/pipelines/batch/slurm.sh
  chunks=$(sbatch --parsable --output="$work/chunk-%a.log" --array=0-$(($(count plan.json) - 1)) "$script" plan.json) &&
    sbatch --wait --output="$work/merge.log" --dependency="afterok:$chunks" "$script" --merge plan.json
}
PATH=$PATH:/usr/sbin
if ! command -v slurmctld >/dev/null || ! command -v slurmd >/dev/null; then
  missing+=("slurm-wlm is not installed")
elif ! start_slurm; then
  missing+=("Slurm does not start here: $(tail -qn 1 slurmctld.log slurmd.log | tr '\n' ' ')")
else
  promise "Slurm gives the same bytes" by_engine by_slurm
fi
[ ${#missing[@]} = 0 ] || skip "$(printf '%s; ' "${missing[@]}")"
