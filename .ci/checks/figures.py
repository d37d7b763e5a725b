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
    rows = [line.split(',') for line in
            (common.ROOT / 'tests/sizes.csv').read_text().splitlines()
            if line.startswith(('text,', 'stack,'))]
    code = {}
    for kind, name, v in rows:
        if kind == 'text':
            part = common.part_of(name)
            code[part] = code.get(part, 0) + int(v)
    stack, name = max((int(v), n) for k, n, v in rows if k == 'stack')
    check = '`sizes.py`'
    for part in ('core', *common.PARTS):
        what = 'the core, without those below' if part == 'core' else part
        yield f'code of {what}, Cortex-M7 -O2', f'{code[part]} bytes', check
    yield 'deepest stack of a public function', f'{stack} bytes (`{name}`)', check


def workspaces():
    for kind, name, n in table_rows('sizes.csv'):
        if kind == 'workspace' and name.startswith(('stream_small', 'stream_fast')):
            yield (f'workspace of a frame of 289x193 lenses, {name.replace("_", " ")}, '
                   'window 9, 17 labels, Cortex-M7', f'{n} bytes', '`sizes.py`')


def instructions():
    for kind, name, n in table_rows('instructions.csv'):
        if kind == 'band':
            yield (f'instructions of a row of 40 lenses, {name}, 5 views, 12 labels, '
                   'Cortex-M7 -O2', n, '`instructions.py`')


def table_rows(name):
    path = common.ROOT / 'tests' / name
    lines = path.read_text().splitlines() if path.exists() else []
    return [line.split(',') for line in lines if not line.startswith('#')][1:]


def targets():
    golden = (common.ROOT / 'tests/golden/golden.c').read_text()
    stages = len(re.findall(r'^    \{"', golden, re.M))
    cross = {p.stem for p in (common.ROOT / '.ci/cross').glob('*.ini')}
    known = cross | {'test', 'clang', 'leon3'}  # x86-64 by gcc and by clang
    passed = [r for r in table_rows('evidence.csv') if r[0] in known and r[1] == '0']
    yield ('targets that gave equal goldens when last tried',
           f'{len(passed)} of {len(known)}', '`tests/evidence.csv`')
    yield 'stages with a golden', str(stages), '`tests/golden`'


def conditions():
    count, shown = map(int, table_rows('mcdc.csv')[0])
    yield ('conditions of the core shown to act on their own (MC/DC)',
           f'{shown} of {count} ({100 * shown / count:.1f} %; 95 asked)',
           '`mcdc.py --note`')


def fuzzing():
    rows = table_rows('fuzz/record.csv')
    hours = sum(int(r[1]) for r in rows) / 3600
    count = sum(int(r[2]) for r in rows)
    yield ('fuzzing in the longest runs without a finding',
           f'{len(rows)} harnesses, {hours:.1f} h, {count // 1000000} million executions',
           '`fuzz.py --record`')


def coverage():
    rows = [line.split(',') for line in
            (common.ROOT / 'tests/coverage.csv').read_text().splitlines()
            if not line.startswith(('#', 'file,'))]
    lines, branches = (sum(int(r[k]) for r in rows) for k in (1, 2))
    yield 'lines of the core that no unit test reaches', str(lines), '`coverage.py`'
    yield 'branches of the core, the same', str(branches), '`coverage.py`'


def mutation():
    for what, tried, seen, argued in table_rows('mutation.csv'):
        yield (f'faults put into the kernels ({what}) that a test sees',
               f'{seen} of {tried}; {argued} more change no result (95 % asked)',
               '`mutation.py --note`')


def faults():
    for what, tried, missed in table_rows('faults.csv'):
        yield f'{what}: tried, got through', f'{tried}, {missed}', '`faults.py`'


def planted():
    text = (common.ROOT / '.ci/checks/planted.py').read_text()
    cases = len(re.findall(r"^    \('", text, re.M))
    yield 'planted violations, each caught', str(cases), '`planted.py`'


def table():
    rows = [*targets(), *sizes(), *workspaces(), *instructions(), *coverage(), *conditions(),
            *mutation(), *fuzzing(), *faults(), *planted()]
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
