#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs the commands of the pages: each line that begins with "$ " in a ```console block, with its continuation lines. A
# command must exit with status 0. One that does not end by itself is interrupted, as with Ctrl-C: a live pipeline one
# second after it began to play, a server as soon as it listens. (A film, num-buffers and timeout have an end.)
#
# A block below a line `<!-- not run: REASON -->` is skipped.
#
# Usage: console-blocks.sh playing | other
#   playing  the pages on which something plays or listens, in real time: three pages at once
#   other    all other pages
# (A command may need the files of the one before it on the same page.)
#
# The commands of a page run in a copy of the repository with in.mp4, and with a window system.

# What plays in real time: hapticsink, a window, the scripts, a server.
playing='hapticsink|autovideosink|sync=true|is-live=true|\./pipelines/|spidar-emulator|--seconds'

# What ends by itself.
ends='\.(mp4|ts)( |$)|num-buffers=|timeout '

# `run COMMAND OUTPUT` runs a command and interrupts it if it does not end by itself.
run() {
  set -m # the command gets a process group of its own, as in a terminal
  : >"$2"
  bash -o pipefail -c "$1" >"$2" 2>&1 </dev/null &
  local process=$!
  until [[ $1 =~ $ends ]] || ! kill -0 "$process" 2>/dev/null; do
    sleep 0.05
    if grep -q 'live and does not need PREROLL' "$2" && grep -q PLAYING "$2"; then
      sleep 1
    elif ! grep -q '^listening' "$2"; then
      continue
    fi
    kill -INT -- "-$process" 2>/dev/null
    break
  done
  wait "$process"
}

# Runs inside the window system: `console-blocks.sh page PAGE CHECKOUT`.
if [ "${1:-}" = page ]; then
  cd "$3" || exit
  wrong=0
  while IFS=$'\t' read -r number command; do
    begin=${EPOCHREALTIME/./}
    status=0
    output=$3.output-$number
    run "$command" "$output" || status=$?
    echo "$2:$number: $(((${EPOCHREALTIME/./} - begin) / 1000)) ms: $command"
    if [ "$status" != 0 ] || grep -qE '^(ERROR|erroneous pipeline)|CRITICAL \*\*' "$output"; then
      echo "FAILED with status $status, after"
      tail -n 20 "${before:-/dev/null}"
      echo "by"
      tail -n 20 "$output"
      wrong=1
    fi
    before=$output
  done <"$3.commands"
  exit $wrong
fi

source "$(dirname "$0")/../pipelines/support.sh"
self=$(realpath "$0")
wanted=${1:-playing}
need_window_system

clip "$work/in.mp4" 352 288 30 1 uniform:40,-20

# `commands PAGE` prints NUMBER<tab>COMMAND for each command.
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
  ' "$root/$1"
}

# `checkout FOLDER` makes a copy of the repository.
checkout() {
  local entry
  mkdir "$1"
  for entry in "$root"/*; do
    case ${entry##*/} in
    build*) ;;
    *) ln -s "$entry" "$1/" ;;
    esac
  done
  ln -s "$build" "$1/build"
  cp "$work/in.mp4" "$1/"
}

# `run_page PAGE`: its name is that of a folder beside which its commands and what they print are.
run_page() {
  local folder=$work/${1//\//-}
  checkout "$folder"
  in_window_system "$self" page "$1" "$folder" >"$folder.said" 2>&1 || touch "$folder.failed"
  cat "$folder.said"
}

count=0
while IFS= read -r page; do
  list=$work/${page//\//-}.commands
  commands "$page" >"$list"
  [ -s "$list" ] || continue
  kind=other
  ! grep -qE -- "$playing" "$list" || kind=playing
  [ $kind = "$wanted" ] || continue
  count=$((count + $(wc -l <"$list")))
  echo "$(wc -l <"$list") $page" >>"$work/pages"
done < <(cd "$root" && printf '%s\n' ./*.md && find docs -name '*.md' | sort)

# The page with the most commands first.
mapfile -t pages < <(sort -rn "$work/pages" | cut -d ' ' -f 2)
for page in "${pages[@]}"; do
  [ "$(jobs -pr | wc -l)" -lt 3 ] || wait -n
  run_page "$page" &
done
wait

failed=("$work"/*.failed)
echo "$count commands of ${#pages[@]} pages run"
[ "$count" -gt 0 ] && [ ! -e "${failed[0]}" ]
