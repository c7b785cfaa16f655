#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Feeds damaged tracks to every parser, guided by coverage (package afl++): inputs that reach new code are mutated
# further. AddressSanitizer, UndefinedBehaviorSanitizer and the assertions of track-fuzz end a process at a finding.
#
# Usage: tests/fuzz/coverage.sh [INPUTS | SECONDSs [PARSER...]]
#   INPUTS  of each parser (default: 1000000, on one processor some minutes each, hours for hmpg and rtp);
#           15s instead: as many as there are in 15 s
#   PARSER  klv, pointer, text, field, relief, hmpg, hjif, rtp (default: all)
# Prints a line for each parser. The exit status is 0 if there was no finding; otherwise each input of a finding is in
# build-fuzz/findings/PARSER/default. Later runs continue from the inputs of the earlier ones.

source "$(dirname "$0")/../../pipelines/shared/common.sh"

case ${1:-} in
--help | -h) show_help && exit ;;
esac
amount=${1:-1000000} limit=-E
[[ $amount =~ ^[1-9][0-9]*s?$ ]] || fail "INPUTS is a number, or seconds as in 15s, not '$amount'; see --help"
[[ $amount != *s ]] || limit=-V
parsers=("${@:2}")
[ ${#parsers[@]} -gt 0 ] || parsers=(klv pointer text field relief hmpg hjif rtp)
command -v afl-clang-fast++ >/dev/null || fail "afl++ is not installed; as root run: apt-get install afl++"

cd "$root"
folder=$root/build-fuzz
forget_interrupted_setup "$folder"
[ -f "$folder/build.ninja" ] ||
  CC=afl-clang-fast CXX=afl-clang-fast++ meson setup "$folder" -Dtrack=enabled -Dvision=disabled -Ddevice=disabled \
    -Dtests=enabled -Dunity=on -Dunity_size=6 -Dbuildtype=debugoptimized -Dwerror=false -Db_lundef=false \
    -Db_sanitize=address,undefined >/dev/null
AFL_QUIET=1 ninja -C "$folder" tests/fuzz/track-fuzz >"$folder/build.log" || { tail -n 30 "$folder/build.log"; exit 1; }
fuzzer=$folder/tests/fuzz/track-fuzz

# afl-fuzz asks for settings of the machine that need root. They only make it faster.
export AFL_SKIP_CPUFREQ=1 AFL_I_DONT_CARE_ABOUT_MISSING_CRASHES=1 AFL_NO_AFFINITY=1 AFL_NO_UI=1 AFL_AUTORESUME=1
export ASAN_OPTIONS=abort_on_error=1:symbolize=0:detect_leaks=0:allocator_may_return_null=1
export UBSAN_OPTIONS=halt_on_error=1:abort_on_error=1
status=0
for parser in "${parsers[@]}"; do
  seeds=$folder/seeds/$parser out=$folder/findings/$parser
  mkdir -p "$seeds" "$out"
  "$fuzzer" "$parser" --seeds "$seeds"
  afl-fuzz -i "$seeds" -o "$out" "$limit" "${amount%s}" -t 2000 -- "$fuzzer" "$parser" >"$out/afl.log" 2>&1 ||
    { tail -n 20 "$out/afl.log"; exit 1; }
  value() { sed -n "s/^$1 *: *//p" "$out/default/fuzzer_stats"; }
  echo "$parser: $(value execs_done) inputs, $(value edges_found) edges of $(value total_edges)," \
    "$(value corpus_count) kept, $(value saved_crashes) crashes, $(value saved_hangs) hangs"
  [ "$(value saved_crashes) $(value saved_hangs)" = "0 0" ] || status=1
done
exit "$status"
