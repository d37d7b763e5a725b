# SPDX-License-Identifier: MIT
"""Lines and branches of the core that no unit test reaches.

usage: coverage.py            build with coverage, run the unit tests, compare with
                              tests/coverage.csv: no file may have more uncovered
       coverage.py --update   write the table anew, on purpose
       coverage.py --show     list the uncovered lines and branches

Branches of argument checks count: a check that no test trips is not proved."""
import json
import sys

import common

TABLE = common.ROOT / 'tests' / 'coverage.csv'
FOLDER = common.ROOT / 'build-ci' / 'coverage'
UPDATE = 'python3 .ci/checks/coverage.py --update'


def build_and_run():
    if not (FOLDER / 'build.ninja').exists():
        common.run('meson', 'setup', FOLDER, common.ROOT, '-Db_coverage=true',
                   '-Dbuildtype=debug', '-Ddefault_library=static', '-Dtools=disabled',
                   '-Dopencl=disabled')
    common.run('ninja', '-C', FOLDER)
    for old in FOLDER.rglob('*.gcda'):
        old.unlink()
    common.run('meson', 'test', '-C', FOLDER, '--no-rebuild', '--suite', 'plenofix:unit')


def measure():
    output = common.run('gcovr', '-r', common.ROOT, '--object-directory', FOLDER,
                        '--filter', str(common.ROOT / 'src') + r'/[^/]*\.[ch]$',
                        '--exclude-unreachable-branches',
                        '--gcov-ignore-parse-errors', '--json', '-', FOLDER / 'src')
    files = json.loads(output)['files']
    result = {}
    for f in files:
        lines = [ln for ln in f['lines'] if not ln.get('gcovr/noncode')]
        bare = sorted({ln['line_number'] for ln in lines if ln['count'] == 0})
        half = [(ln['line_number'], sum(1 for b in ln['branches'] if b['count'] == 0))
                for ln in lines]
        result[f['file'].split('src/')[-1]] = (
            len(lines), bare, sum(len(ln['branches']) for ln in lines),
            [h for h in half if h[1]])
    return result


def read():
    rows = {}
    for line in TABLE.read_text().splitlines():
        if not line.startswith(('#', 'file,')):
            name, lines, branches = line.split(',')
            rows[name] = int(lines), int(branches)
    return rows


def write(now):
    with open(TABLE, 'w') as out:
        out.write('# Lines and branches of the core that no unit test reaches; may only '
                  'fall.\n# Written by ' + UPDATE + '\nfile,lines,branches\n')
        for name in sorted(now):
            _, bare, _, half = now[name]
            out.write(f'{name},{len(bare)},{sum(h[1] for h in half)}\n')


def show(now):
    for name in sorted(now):
        _, bare, _, half = now[name]
        if bare or half:
            print(f'{name}: lines {bare}; branches ' +
                  ', '.join(f'{n} ({c})' for n, c in half))


common.need('gcovr')
build_and_run()
now = measure()
lines = sum(v[0] for v in now.values())
bare = sum(len(v[1]) for v in now.values())
branches = sum(v[2] for v in now.values())
half = sum(h[1] for v in now.values() for h in v[3])
print(f'lines {lines - bare} of {lines} ({100 * (lines - bare) / lines:.2f} %), branches '
      f'{branches - half} of {branches} ({100 * (branches - half) / branches:.2f} %)')
if '--show' in sys.argv:
    show(now)
    sys.exit(0)
if '--update' in sys.argv:
    write(now)
    sys.exit(0)
allowed, findings = read(), []
for name, (_, bare_lines, _, half_branches) in sorted(now.items()):
    was = allowed.get(name, (0, 0))
    new = len(bare_lines), sum(h[1] for h in half_branches)
    if new[0] > was[0] or new[1] > was[1]:
        findings.append(f'{name}: {new[0]} lines and {new[1]} branches uncovered, allowed '
                        f'{was[0]} and {was[1]}; see coverage.py --show')
    elif new != was:
        print(f'{name}: better than the table; {UPDATE}')
common.verdict(findings, 'coverage')
