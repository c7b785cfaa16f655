#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Counts results for tests/run.sh and tests/other-debian.sh.

Usage: tests/summary.py failed TESTLOG                               the tests of a JSON log of meson to repeat
       tests/summary.py collect PREFIX TESTLOG OUTPUTS >>RESULTS     one line per test of the log
       tests/summary.py close RESULTS OUTPUTS                        prints what failed, why tests were skipped, the counts

Beside the other tests, on a machine with other work, one of real time may be too late. So the few that failed are
repeated alone, into the log TESTLOG with `-alone` before its ending. What then passes is counted as passed, and what it
printed the first time is shown.

A line of RESULTS is `passed`, `failed` or `skipped`, the name, the duration in seconds and the reason, with
tabs between them. OUTPUTS is a folder with what each failed test printed, under its name. `close` ends with
status 1 if a test failed or none ran.
"""
import collections
import json
import pathlib
import re
import sys

OUTCOMES = {'OK': 'passed', 'EXPECTEDFAIL': 'passed', 'SKIP': 'skipped'}
SLOWEST = 10
REPEATED = 5  # if more have failed, the machine is not the reason
ALONE = 'passed alone'
LAST_LINES = 40  # of a failed test: a long log is often cut in the middle, so its end repeats them


def tests_of(path):
    if not path.exists():
        return {}
    with path.open(encoding='utf-8') as log:
        tests = [json.loads(line) for line in log]
    return {test['name'].split(' / ')[-1]: test for test in tests}


def outcome_of(test):
    return OUTCOMES.get(test['result'], 'failed')


def failed(path):
    names = [name for name, test in tests_of(pathlib.Path(path)).items() if outcome_of(test) == 'failed']
    if len(names) <= REPEATED:
        print(*names, sep='\n', end='\n' if names else '')


def skip_reason(output):
    found = re.search(r'^SKIP(?:PED)?: *(.+)$', output, re.MULTILINE)
    return found[1].strip() if found else 'no reason given'


def output_of(name, outputs):
    return pathlib.Path(outputs, name.replace('/', '-'))


def collect(prefix, path, outputs):
    path = pathlib.Path(path)
    alone = tests_of(path.with_stem(path.stem + '-alone'))
    for name, test in tests_of(path).items():
        outcome, reason = outcome_of(test), test['result']
        output = (test.get('stdout') or '') + '\n' + (test.get('stderr') or '')
        if outcome == 'skipped':
            reason = skip_reason(output)
        elif outcome == 'failed':
            output_of(prefix + name, outputs).write_text(output, encoding='utf-8')
            if name in alone and outcome_of(alone[name]) == 'passed':
                outcome, reason = 'passed', ALONE
        print(outcome, prefix + name, f"{test['duration']:.2f}", reason.replace('\t', ' '), sep='\t')


def last_lines(path):
    if not path.exists():
        return ''
    lines = path.read_text(encoding='utf-8', errors='replace').rstrip().splitlines()
    return ''.join(f'    {line}\n' for line in lines[-LAST_LINES:])


def close(path, outputs):
    with open(path, encoding='utf-8') as file:
        results = [line.rstrip('\n').split('\t') for line in file]
    counts = collections.Counter(outcome for outcome, *_ in results)
    reasons = collections.Counter(reason for outcome, _, _, reason in results if outcome == 'skipped')
    print('\nThe slowest, in seconds:')
    for _, name, duration, _ in sorted(results, key=lambda result: -float(result[2]))[:SLOWEST]:
        print(f'{float(duration):8.1f}  {name}')
    for outcome, name, _, reason in results:
        if outcome == 'failed' or reason == ALONE:
            how = 'failed' if outcome == 'failed' else 'failed beside others'
            print(f"{how}: {name} ({reason})\n{last_lines(output_of(name, outputs))}", end='')
    if reasons:
        print(f"skipped {counts['skipped']}: " +
              ', '.join(f'{reason} ({count})' for reason, count in reasons.most_common()))
    print(f"\n{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return 1 if counts['failed'] or not counts['passed'] else 0


if __name__ == '__main__':
    if len(sys.argv) == 5 and sys.argv[1] == 'collect':
        collect(*sys.argv[2:])
    elif len(sys.argv) == 3 and sys.argv[1] == 'failed':
        failed(sys.argv[2])
    elif len(sys.argv) == 4 and sys.argv[1] == 'close':
        sys.exit(close(*sys.argv[2:]))
    else:
        sys.exit(__doc__)
