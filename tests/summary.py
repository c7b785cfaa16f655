#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Counts results for tests/run.sh and tests/other-debian.sh.

Usage: tests/summary.py failed TESTLOG                          what to repeat alone of a JSON log of meson
       tests/summary.py collect PREFIX LOGS OUTPUTS >>RESULTS   one line for each test of LOGS/testlog.json
       tests/summary.py first PREFIX LOGS OUTPUTS >>RESULTS     the same of sanitized tests that are run again
       tests/summary.py close SIZE RESULTS OUTPUTS              prints what failed, why tests were skipped, the counts

A machine with other work may be too slow for a test. So each case of a GoogleTest program and each script that failed is
repeated alone. `failed` prints one line for each: the test, a tab, and the case, if there is one. Whoever repeats them
writes those lines that passed into LOGS/alone. A test whose failures all pass alone counts as passed; the closing lines
name it with what it printed the first time.

Sanitized tests are run again otherwise, since a leak may be GLib's own. An error of memory or undefined behaviour counts
as failed, whether it comes again or not.

A test that is late now and then is a defect of the test. The last five runs are remembered, and `close all` counts a
test as failed that was repeated in two of them.

A line of RESULTS is `passed`, `failed`, `skipped` or `waited`, the name, the duration in seconds and the reason, with
tabs between them. OUTPUTS is a folder with what each failed test printed, under its name. `close` ends with status 1 if
a test failed or none ran.
"""
import collections
import json
import os
import pathlib
import re
import sys

OUTCOMES = {'OK': 'passed', 'EXPECTEDFAIL': 'passed', 'SKIP': 'skipped'}
SLOWEST = 10
ALONE = 'passed alone'
RUNS = 5  # that are remembered
TOO_OFTEN = 2  # of these
LAST_LINES = 40  # of a failed test: a long log is often cut in the middle, so its end repeats them


def tests_of(path):
    if not path.exists():
        return {}
    with path.open(encoding='utf-8') as log:
        tests = [json.loads(line) for line in log]
    return {test['name'].split(' / ')[-1]: test for test in tests}


def outcome_of(test):
    return OUTCOMES.get(test['result'], 'failed')


def output_of(test):
    return (test.get('stdout') or '') + '\n' + (test.get('stderr') or '')


def failures_of(name, test):
    """What to repeat of a failed test. A program that ended early names no case: all of it is repeated."""
    output = output_of(test)
    ended = re.search(r'^\[==========\] .* ran\.', output, re.MULTILINE)
    cases = re.findall(r'^\[  FAILED  \] ([^\s,]+)(?:, where .*)?$', output, re.MULTILINE) if ended else []
    return [(name, case) for case in dict.fromkeys(cases)] or [(name, '')]


def failed(path):
    for name, test in tests_of(pathlib.Path(path)).items():
        if outcome_of(test) == 'failed':
            for failure in failures_of(name, test):
                print(*failure, sep='\t')


def skip_reason(output):
    found = re.search(r'^SKIP(?:PED)?: *(.+)$', output, re.MULTILINE)
    return found[1].strip() if found else 'no reason given'


def file_of(name, outputs):
    return pathlib.Path(outputs, name.replace('/', '-'))


def collect(prefix, logs, outputs):
    logs = pathlib.Path(logs)
    alone = set()
    if (logs / 'alone').exists():
        alone = {tuple(line.split('\t')) for line in (logs / 'alone').read_text(encoding='utf-8').splitlines()}
    for name, test in tests_of(logs / 'testlog.json').items():
        outcome, reason = outcome_of(test), test['result']
        if outcome == 'skipped':
            reason = skip_reason(output_of(test))
        elif outcome == 'failed':
            file_of(prefix + name, outputs).write_text(output_of(test), encoding='utf-8')
            if alone.issuperset(failures_of(name, test)):
                outcome, reason = 'passed', ALONE
        print(outcome, prefix + name, f"{test['duration']:.2f}", reason.replace('\t', ' '), sep='\t')


def first(prefix, logs, outputs):
    for name, test in tests_of(pathlib.Path(logs, 'testlog.json')).items():
        outcome, reason = outcome_of(test), test['result']
        output = output_of(test)
        label = prefix + name
        if outcome == 'skipped':
            reason = skip_reason(output)
        elif outcome == 'failed':
            label += ', first run'
            file_of(label, outputs).write_text(output, encoding='utf-8')
            if re.search('ERROR: AddressSanitizer|runtime error:', output):
                reason = 'an error of memory, or undefined behaviour'
            elif 'LeakSanitizer' in output:
                continue
            else:
                outcome, reason = 'passed', ALONE  # the second run says so if it did not
        print(outcome, label, f"{test['duration']:.2f}", reason.replace('\t', ' '), sep='\t')


def last_lines(path):
    if not path.exists():
        return ''
    lines = path.read_text(encoding='utf-8', errors='replace').rstrip().splitlines()
    return ''.join(f'    {line}\n' for line in lines[-LAST_LINES:])


def repeated_too_often(repeated):
    """Remembers the tests that this run has repeated. Returns those that were repeated too often."""
    state = os.environ.get('XDG_STATE_HOME') or pathlib.Path.home() / '.local' / 'state'
    path = pathlib.Path(state, 'feeling-wind', 'repeated-tests')
    try:
        runs = path.read_text(encoding='utf-8').splitlines() if path.exists() else []
        runs = (runs + ['\t'.join(repeated)])[-RUNS:]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text('\n'.join(runs) + '\n', encoding='utf-8')
    except OSError as error:
        print(f'The tests that were repeated are not remembered: {error}')
        return []
    times = collections.Counter(name for run in runs for name in set(run.split('\t')) if name)
    return [name for name in repeated if times[name] >= TOO_OFTEN]


def close(size, path, outputs):
    with open(path, encoding='utf-8') as file:
        lines = [line.rstrip('\n').split('\t') for line in file]
    waited = sum(max(0, float(line[2])) for line in lines if line[0] == 'waited')
    results = [line for line in lines if line[0] != 'waited']
    repeated = [name for _, name, _, reason in results if reason == ALONE]
    too_often = repeated_too_often(repeated)
    if size == 'all':
        results = [['failed', *line[1:3], f'repeated in {TOO_OFTEN} of the last {RUNS} runs'] if line[1] in too_often else line
                   for line in results]
    counts = collections.Counter(outcome for outcome, *_ in results)
    reasons = collections.Counter(reason for outcome, _, _, reason in results if outcome == 'skipped')
    print('\nThe slowest, in seconds:')
    for _, name, duration, _ in sorted(results, key=lambda result: -float(result[2]))[:SLOWEST]:
        print(f'{float(duration):8.1f}  {name}')
    print(f'The tests waited {waited:.0f} s in all.')
    for outcome, name, _, reason in results:
        if outcome == 'failed' or reason == ALONE:
            how = 'failed' if outcome == 'failed' else 'repeated'
            print(f"{how}: {name} ({reason})\n{last_lines(file_of(name, outputs))}", end='')
    if reasons:
        print(f"skipped {counts['skipped']}: " +
              ', '.join(f'{reason} ({count})' for reason, count in reasons.most_common()))
    print(f"\n{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return 1 if counts['failed'] or not counts['passed'] else 0


if __name__ == '__main__':
    if len(sys.argv) == 5 and sys.argv[1] in ('collect', 'first'):
        {'collect': collect, 'first': first}[sys.argv[1]](*sys.argv[2:])
    elif len(sys.argv) == 3 and sys.argv[1] == 'failed':
        failed(sys.argv[2])
    elif len(sys.argv) == 5 and sys.argv[1] == 'close':
        sys.exit(close(*sys.argv[2:]))
    else:
        sys.exit(__doc__)
