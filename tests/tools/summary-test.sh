#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# What tests/run.sh counts and repeats. Usage: summary-test.sh SUMMARY
summary=$1
source "$(dirname "$0")/../support/promise.sh"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_STATE_HOME=$work/state

# `logged NAME=RESULT[=OUTPUT]...`: what meson writes. (In OUTPUT, \n is the end of a line.)
logged() {
  local test name result output
  for test; do
    IFS='=' read -r name result output <<<"$test"
    printf '{"name": "unit / %s", "result": "%s", "duration": 1, "stdout": "%s"}\n' \
      "$name" "$result" "${output:-$name said this}"
  done >"$work/testlog.json"
  rm -f "$work/alone"
}
passed_alone() { printf '%s\t%s\n' "$@" >"$work/alone"; }
closed() {
  "$summary" collect '' "$work" "$work" >"$work/results" || return 2
  "$summary" close "${1:-quick}" "$work/results" "$work" >"$work/closed"
}
says() { grep -qxF "$1" "$work/closed" || { cat "$work/closed"; return 1; }; }
fails() { ! "$@"; }
repeats() { diff <("$summary" failed "$work/testlog.json") <(printf %b "$1"); }

logged late=FAIL broken=TIMEOUT good=OK
passed_alone late ''
promise "what failed is repeated" repeats 'late\t\nbroken\t\n'
promise "what fails alone, too, is a failure" fails closed
promise "and counted" says '2 passed, 1 failed, 0 skipped'
promise "what passes alone is named" says 'repeated: late (passed alone)'
promise "and what it printed is shown" says '    late said this'

logged a=FAIL b=FAIL c=FAIL d=FAIL e=FAIL f=FAIL g=FAIL
passed_alone a '' b '' c '' d '' e '' f '' g ''
promise "however many failed, all are repeated" repeats 'a\t\nb\t\nc\t\nd\t\ne\t\nf\t\ng\t\n'
promise "and none is a failure that passes alone" closed

ran='[  FAILED  ] Some.Case (3 ms)\n[==========] 9 tests from 2 test suites ran. (7 ms total)\n[  FAILED  ] 2 tests, listed below:\n'
listed='[  FAILED  ] Some.Case\n[  FAILED  ] All/Of.Them/1, where GetParam() is 4\n'
json=${ran//\\/\\}${listed//\\/\\}
logged "gtest=FAIL=$json"
promise "of a GoogleTest program only the cases that failed" repeats 'gtest\tSome.Case\ngtest\tAll/Of.Them/1\n'
passed_alone gtest Some.Case
promise "one of which fails alone" fails closed
passed_alone gtest Some.Case gtest All/Of.Them/1
promise "or none" closed
logged 'gtest=FAIL=[  FAILED  ] Some.Case'
promise "all of a program that ended early" repeats 'gtest\t\n'

rm -rf "$XDG_STATE_HOME"
logged late=FAIL good=OK
passed_alone late ''
promise "a test that is late once" closed all
logged late=OK good=OK
for _ in {1..3}; do
  closed all
done
logged late=FAIL good=OK
passed_alone late ''
promise "and again in the fifth run" fails closed all
promise "is a failure" says '1 passed, 1 failed, 0 skipped'
rm -rf "$XDG_STATE_HOME"
closed all
logged good=OK
for _ in {1..4}; do
  closed all
done
logged late=FAIL good=OK
passed_alone late ''
promise "but not in the sixth" closed all

logged good=OK
promise "without a failure nothing is repeated" repeats ''
promise "and nothing fails" closed
printf 'waited\tbuild\t12.4\t\n' >>"$work/results"
"$summary" close quick "$work/results" "$work" >"$work/closed"
promise "how long the tests waited is said" says 'The tests waited 12 s in all.'
promise "and is no test" says '1 passed, 0 failed, 0 skipped'
logged
promise "no test at all is a failure" fails closed
logged good=OK
promise "without a place to remember anything the tests are counted" env XDG_STATE_HOME=/proc/none \
  "$summary" close quick <(printf 'passed\tgood\t1\tOK\n') "$work"

# The first run of sanitized tests.
judged() { diff <("$summary" first 'sanitized ' "$work" "$work") <(printf %b "$1"); }
logged 'freed=FAIL=ERROR: AddressSanitizer: heap-use-after-free' 'shift=FAIL=a.cpp:1:2: runtime error: shift exponent' \
  'leak=FAIL=ERROR: LeakSanitizer: detected memory leaks\\nSUMMARY: AddressSanitizer' late=TIMEOUT good=OK
promise "an error of memory counts at once, a leak is judged by the second run" judged \
  'failed\tsanitized freed, first run\t1.00\tan error of memory, or undefined behaviour
failed\tsanitized shift, first run\t1.00\tan error of memory, or undefined behaviour
passed\tsanitized late, first run\t1.00\tpassed alone
passed\tsanitized good\t1.00\tOK
'

# Stands for `meson test`: a program of two cases fails, one of which passes alone.
root=$(cd "$(dirname "$0")/../.." && pwd)
source "$root/tests/support/repeat.sh"
pretended=2 # its status
played() {
  if [[ " $* " = *" --logbase testlog-alone "* ]]; then
    # A shard of a program would leave its case out, and pass.
    [[ $* = *"--wrapper=env -u GTEST_TOTAL_SHARDS -u GTEST_SHARD_INDEX "*"--gtest_filter=Some.Case late"* ]]
    return
  fi
  logged "late=FAIL=${ran//\\/\\}[  FAILED  ] Some.Case\\n" broken=FAIL good=OK
  return "$pretended"
}
repeated() { run_and_repeat "$work" 2 played >/dev/null; }
promise "each failure is repeated" repeated
promise "and what passes alone is noted" diff "$work/alone" <(printf 'late\tSome.Case\n')
pretended=3
promise "a run that went wrong otherwise is noticed" fails repeated

counted() {
  local before
  count_processor_time
  before=$processor_time
  python3 -c 'import time
while time.process_time() < 1.2: pass'
  count_processor_time
  [ "$processor_time" -gt "$before" ]
}
promise "the processor time of commands is counted" counted
