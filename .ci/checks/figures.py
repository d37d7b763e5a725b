# SPDX-License-Identifier: MIT
"""The table of figures in README.md, made from the tables that CI holds.
usage: figures.py            is the table in README.md the one that would be written?
       figures.py --update   write it"""
import re
import sys

import common

README = common.ROOT / 'README.md'
BEGIN, END = '<!-- figures -->\n', '<!-- end of figures -->\n'


def sizes():
    frame = re.search(r"FRAME = \{([^}]*)\}",
                      (common.ROOT / '.ci/checks/sizes.py').read_text())
    apart = set(re.findall(r"'(\w+)'", frame[1])) if frame else set()
    rows = [line.split(',') for line in
            (common.ROOT / 'tests/sizes.csv').read_text().splitlines()
            if line.startswith(('text,', 'stack,'))]
    code = sum(int(v) for k, n, v in rows if k == 'text' and n not in apart)
    whole = sum(int(v) for k, n, v in rows if k == 'text' and n in apart)
    stack, name = max((int(v), n) for k, n, v in rows if k == 'stack')
    check = '`sizes.py`'
    yield 'code of the core but for frame.h, Cortex-M7 -O2', f'{code} bytes', check
    yield 'code of frame.h, the same', f'{whole} bytes', check
    yield 'deepest stack of a public function', f'{stack} bytes (`{name}`)', check


def targets():
    cross = len(list((common.ROOT / '.ci/cross').glob('*.ini')))
    golden = (common.ROOT / 'tests/golden/golden.c').read_text()
    stages = len(re.findall(r'^    \{"', golden, re.M))
    # x86-64 by gcc and clang, and the bare LEON3
    yield 'targets whose goldens are compared', str(cross + 3), '`.ci/run --full`'
    yield 'stages with a golden', str(stages), '`tests/golden`'


def coverage():
    rows = [line.split(',') for line in
            (common.ROOT / 'tests/coverage.csv').read_text().splitlines()
            if not line.startswith(('#', 'file,'))]
    lines, branches = (sum(int(r[k]) for r in rows) for k in (1, 2))
    yield 'lines of the core that no unit test reaches', str(lines), '`coverage.py`'
    yield 'branches of the core, the same', str(branches), '`coverage.py`'


def planted():
    text = (common.ROOT / '.ci/checks/planted.py').read_text()
    cases = len(re.findall(r"^    \('", text, re.M))
    yield 'planted violations, each caught', str(cases), '`planted.py`'


def table():
    rows = [*targets(), *sizes(), *coverage(), *planted()]
    head = '| figure | value | held by |\n| --- | --- | --- |\n'
    return head + ''.join(f'| {a} | {b} | {c} |\n' for a, b, c in rows)


text = README.read_text()
start, stop = text.index(BEGIN) + len(BEGIN), text.index(END)
new = text[:start] + table() + text[stop:]
if '--update' in sys.argv:
    README.write_text(new)
elif new != text:
    print('README.md: the table of figures is old; python3 .ci/checks/figures.py --update')
    sys.exit(1)
print('figures: README.md is in step')
