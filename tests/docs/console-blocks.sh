#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs every command of the pages: each line that begins with "$ " in a ```console block, with its
# continuation lines. A command must succeed. One that does not end within some seconds is interrupted,
# as with Ctrl-C, and must then exit with status 0.
#
# A block below a line `<!-- not run: REASON -->` is skipped.
#
# The commands run in a copy of the repository with in.mp4, and with a window system.

# `console-blocks.sh PART PARTS` runs the commands of every PARTSth page, beginning with number PART. (A command may
# need the files of the one before it on the same page.)

# Runs inside the window system: `console-blocks.sh run COMMAND OUTPUT`. A command that does not end is
# interrupted 7 s after it began to play, or else after 40 s.
if [ "${1:-}" = run ]; then
  set -m # the command gets a process group of its own, as in a terminal
  bash -o pipefail -c "$2" </dev/null &
  process=$!
  playing=0
  for ((tenths = 0; tenths < 400 && playing < 70; tenths++)); do
    kill -0 "$process" 2>/dev/null || break
    ! grep -q PLAYING "$3" || playing=$((playing + 1))
    sleep 0.1
  done
  kill -INT -- "-$process" 2>/dev/null || true
  wait "$process"
  exit
fi

source "$(dirname "$0")/../pipelines/support.sh"
self=$(realpath "$0")
part=${1:-1} parts=${2:-1}
need_window_system

scratch=$work/checkout
mkdir "$scratch"
for entry in "$root"/*; do
  case ${entry##*/} in
  build*) ;;
  *) ln -s "$entry" "$scratch/" ;;
  esac
done
ln -s "$build" "$scratch/build"
clip "$scratch/in.mp4" 352 288 30 4 uniform:40,-20

# Prints NUMBER<tab>COMMAND for each command of a page.
commands() {
  awk '
    /^```/ {
      if (open) { open = 0 } else { open = 1; run = ($0 ~ /^```console/) && (before !~ /^<!-- not run: ./) }
      before = $0
      next
    }
    open && run && /^\$ / { number = NR; text = substr($0, 3); more = 1 }
    open && run && more && !/^\$ / { text = text $0 }
    open && run && more { if (sub(/\\$/, "", text)) next; print number "\t" text; more = 0 }
    !open && NF { before = $0 }
  ' "$1"
}

count=0 wrong=0 pages=0
while IFS= read -r page; do
  pages=$((pages + 1))
  [ $((pages % parts)) = $((part % parts)) ] || continue
  while IFS=$'\t' read -r number command; do
    count=$((count + 1))
    echo "$page:$number: $command"
    # shellcheck disable=SC2094 # it reads there what the command has written so far
    if ! (cd "$scratch" && in_window_system "$self" run "$command" "$work/output") >"$work/output" 2>&1 ||
      grep -qE '^(ERROR|erroneous pipeline)|CRITICAL \*\*' "$work/output"; then
      echo "FAILED"
      tail -n 20 "$work/output"
      wrong=$((wrong + 1))
    fi
  done < <(commands "$root/$page")
done < <(cd "$root" && printf '%s\n' ./*.md && find docs -name '*.md' | sort)

echo "$count commands run, $wrong failed"
[ "$count" -gt 0 ] && [ "$wrong" = 0 ]
