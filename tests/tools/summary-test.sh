#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# What tests/run.sh counts. Usage: summary-test.sh SUMMARY
summary=$1
source "$(dirname "$0")/../support/promise.sh"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# `logged NAME=RESULT...`: what meson writes.
logged() {
  local test
  for test; do
    printf '{"name": "unit / %s", "result": "%s", "duration": 1, "stdout": "%s said this"}\n' "${test%=*}" "${test#*=}" "${test%=*}"
  done
}
closed() {
  "$summary" collect '' "$work/log.json" "$work" >"$work/results" || return 2
  "$summary" close "$work/results" "$work" >"$work/closed"
}
says() { grep -qxF "$1" "$work/closed" || { cat "$work/closed"; return 1; }; }
fails() { ! "$@"; }

logged late=FAIL broken=TIMEOUT good=OK >"$work/log.json"
logged late=OK broken=FAIL >"$work/log-alone.json"
promise "what failed is repeated" [ "$("$summary" failed "$work/log.json")" = $'late\nbroken' ]
promise "what fails alone, too, is a failure" fails closed
promise "and counted" says '2 passed, 1 failed, 0 skipped'
promise "what passes alone is named" says 'failed beside others: late (passed alone)'
promise "and what it printed is shown" says '    late said this'
logged a=FAIL b=FAIL c=FAIL d=FAIL e=FAIL f=FAIL >"$work/log.json"
promise "of many failures none is repeated" [ "$("$summary" failed "$work/log.json")" = '' ]
rm "$work/log-alone.json"
promise "and all count" fails closed
logged good=OK >"$work/log.json"
promise "without a failure nothing is repeated" [ "$("$summary" failed "$work/log.json")" = '' ]
promise "and nothing fails" closed
: >"$work/log.json"
promise "no test at all is a failure" fails closed
