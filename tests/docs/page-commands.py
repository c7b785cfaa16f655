#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Commands that no test of the pages runs say which test does, or what they need. Each picture has its command.

Usage: page-commands.py SOURCES
"""
import pathlib
import re
import sys

sources = pathlib.Path(sys.argv[1])
pages = sorted([*sources.glob('*.md'), *sources.glob('docs/**/*.md')])
wrong = []

excuse = re.compile(r'<!-- not run: (.*) -->\n+```console$', re.M)
for page in pages:
    name, text = page.relative_to(sources), page.read_text()
    for reason in excuse.findall(text):
        tests = re.findall(r'\btests/[\w./-]*\w', reason)
        if not (any((sources / test).exists() for test in tests) or 'needs ' in reason):
            wrong.append(f'{name}: "not run: {reason}" names neither a test nor what the command needs')
    for kind in re.findall(r'^```(sh|bash|shell)$', text, re.M):
        wrong.append(f'{name}: commands stand in a block "console", which is run, and not in "{kind}"')

# CONTRIBUTING.md has a table of commands for each folder of pictures and each picture beside the folders.
table = (sources / 'CONTRIBUTING.md').read_text().partition('Each picture in `docs/images` has')[2]
table = table.partition('\n## ')[0]
for script in re.findall(r'[\w-]+\.sh', table):
    if not any(sources.glob(f'pipelines/**/{script}')) and not any(sources.glob(f'tests/**/{script}')):
        wrong.append(f'CONTRIBUTING.md: there is no {script}')
pictures = {path.relative_to(sources / 'docs/images').parts for path in sources.glob('docs/images/**/*.*')}
for place in sorted({parts[0] + '/' * (len(parts) > 1) for parts in pictures}):
    if f'`{place}`' not in table:
        wrong.append(f'docs/images/{place}: the table of pictures in CONTRIBUTING.md has no command for it')

print(*wrong, sep='\n', end='\n' if wrong else '')
print(f'{len(pages)} pages, {len(pictures)} pictures, {len(wrong)} wrong')
sys.exit(bool(wrong) or len(pages) < 40)
