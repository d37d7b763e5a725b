# SPDX-License-Identifier: MIT
"""src/NUMERICS.md against the tree: every test that the documents name exists, every row
of a table of formats or bounds names a test, and every field of the public headers whose
name tells a Q format stands there.

usage: numbers.py               the documents and headers of this tree
       numbers.py FILE.md FILE.h   of a planted violation"""
import pathlib
import re
import sys

import common

DOCUMENTS = ['src/NUMERICS.md', 'src/DESIGN.md', 'tests/README.md', 'SECURITY.md',
             'CONTRIBUTING.md', 'README.md', 'tests/ref/README.md']
ELSEWHERE = ('plfx_',)  # types and functions


def tests():
    """Names as documents give them: test_NAME of any folder, bench_NAME."""
    root = common.ROOT / 'tests'
    named = {p.stem for p in root.glob('*/test_*.c')}
    for path in root.glob('bench/*.*'):
        named.add('bench_' + path.stem)
    for path in (root / 'tools', root / 'port'):
        named |= {'test_' + p.stem for p in path.glob('*.sh')}
    return named


def absent(path, known):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        for name in re.findall(r'\b((?:test|bench)_[a-z0-9_]+)', line):
            if name.rstrip('_') not in known and not line[line.index(name):].startswith(
                    name + '*'):
                yield f'{path.name}:{number}: {name} does not exist'


def unheld(path, known):
    """Rows of the tables of formats without a test."""
    head = None
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if not line.startswith('|'):
            head = None
            continue
        cells = [c.strip() for c in line.strip('|').split('|')]
        if head is None:
            head = cells
            if cells[-1] != 'held by':
                yield f'{path.name}:{number}: a table without "held by"'
        elif not set(cells[0]) <= set('-') and not any(
                n in known for n in re.findall(r'\w+', cells[-1])):
            yield f'{path.name}:{number}: no test holds "{cells[0]}"'


def fields(header):
    """Members of structures that name their format; constants and parameters not."""
    text = common.strip_comments(header.read_text())
    for body in re.findall(r'struct \w+ \{(.*?)\n\}', text, re.S):
        for name in re.findall(r'\b([a-z]\w*_[qu]\d+)\b', body):
            if not name.startswith(ELSEWHERE):
                yield name


args = [pathlib.Path(a) for a in sys.argv[1:]]
numbers = args[0] if args else common.ROOT / 'src/NUMERICS.md'
documents = args[:1] or [common.ROOT / d for d in DOCUMENTS]
headers = args[1:] or sorted((common.ROOT / 'include/plenofix').glob('*.h'))
known = tests()
findings = [f for d in documents if d.exists() for f in absent(d, known)]
findings += unheld(numbers, known)
told = set(re.findall(r'`(\w+)`', numbers.read_text()))
for header in headers:
    findings += [f'{header.name}: {n} is not in {numbers.name}'
                 for n in dict.fromkeys(fields(header)) if n not in told]
common.verdict(findings, 'numbers')
