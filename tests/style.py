#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs clang-tidy on the sources of the project, as many at once as there are processors.

Usage: tests/style.py BUILD [BASE]

BUILD is a configured build folder whose commands clang understands. With BASE, a commit, only files are read whose
content that commit does not have under any name; a header is read with one source that includes it.
Tests are read alone as well, which finds a missing #include, but with one check.
Ends with status 1 if clang-tidy finds something or a file cannot be read.
"""
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

FOLDERS = ('gst-plugins', 'pipelines', 'spidar')
TESTS = 'tests'
TEST_CHECKS = '-checks=-*,bugprone-use-after-move'
CLANG_TIDY = 'clang-tidy-22' if shutil.which('clang-tidy-22') else 'clang-tidy'
ENDINGS = {'.c', '.cpp', '.h', '.hpp'}


def git(*arguments):
    return subprocess.run(('git', *arguments), check=True, capture_output=True, text=True).stdout


def content_of(base):
    return {line.split()[2] for line in git('ls-tree', '-r', base).splitlines()}


def changed_since(base, files):
    known = content_of(base)
    names = [str(file) for file in files]
    return {file for file, content in zip(files, git('hash-object', *names).split()) if content not in known}


def includers_of(files):
    """Of each file name, the files that include a file of this name."""
    includers = collections.defaultdict(list)
    for file in files:
        for name in re.findall(r'^\s*#\s*include\s+["<]([^">]+)', file.read_text(encoding='utf-8'), re.MULTILINE):
            includers[pathlib.PurePath(name).name].append(file)
    return includers


def source_that_reads(header, sources, includers):
    """A source that includes the header, directly if there is one, and its own before any other."""
    seen, level = {header}, [header]
    while level:
        found = [file for of in level for file in includers[of.name] if file not in seen]
        direct = sorted((file for file in found if file in sources), key=lambda file: (file.stem != header.stem, file))
        if direct:
            return direct[0]
        seen.update(found)
        level = found
    return None


def to_read(sources, base):
    if not base:
        return set(sources)
    files = [file for folder in FOLDERS for file in sorted(pathlib.Path(folder).rglob('*')) if file.suffix in ENDINGS]
    changed, includers = changed_since(base, files), includers_of(files)
    read = {file if file in sources else source_that_reads(file, sources, includers) for file in changed}
    return read - {None}


def tidy(build, source):
    checks = (TEST_CHECKS,) if source.parts[0] == TESTS else ()
    ran = subprocess.run((CLANG_TIDY, '-quiet', '-p', build, *checks, source), capture_output=True, text=True)
    return source, ran.returncode, ran.stdout + ran.stderr


def main(build, base=''):
    with open(pathlib.Path(build, 'compile_commands.json'), encoding='utf-8') as file:
        commands = {os.path.relpath(os.path.join(entry['directory'], entry['file'])): entry for entry in json.load(file)}
    # Each source once, also if several programs have it.
    database = pathlib.Path(build, 'clang-tidy')
    database.mkdir(exist_ok=True)
    (database / 'compile_commands.json').write_text(json.dumps(list(commands.values())), encoding='utf-8')
    sources = {pathlib.Path(name) for name in commands if name.startswith(tuple(f'{folder}/' for folder in FOLDERS))}
    tests = sorted({pathlib.Path(name) for name in commands if name.startswith(f'{TESTS}/')})
    read = sorted(to_read(sources, base) | (changed_since(base, tests) if base else set(tests)))
    print(f'{len(read)} of {len(sources) + len(tests)} sources' + (f', for what differs from {base}' if base else ''))
    status = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for source, failed, output in pool.map(lambda source: tidy(database, source), read):
            if failed:
                status = 1
                print(f'{source}:\n{output}')
    return status


if __name__ == '__main__':
    if not 2 <= len(sys.argv) <= 3 or sys.argv[1].startswith('-'):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
