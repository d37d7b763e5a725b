# SPDX-License-Identifier: MIT
"""Modified condition/decision coverage of the core by the unit tests, by clang 19.

usage: mcdc.py                at least 95 % of the conditions shown to act on their own;
                              each of the rest is argued in tests/mcdc.txt
       mcdc.py --show         list what is not shown, with the decision's text
       mcdc.py --note         write the counts to tests/mcdc.csv, for README.md
       mcdc.py --report FILE  the same check of a report made before (llvm-cov's JSON)

A line of tests/mcdc.txt: file | conditions | text of the decision | reason."""
import json
import os
import pathlib
import re
import subprocess
import sys

import common

FOLDER = common.ROOT / 'build-ci' / 'mcdc'
ARGUED = common.ROOT / 'tests' / 'mcdc.txt'
COUNTS = common.ROOT / 'tests' / 'mcdc.csv'
LEAST = 95.0


def run(*command, **env):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True,
                          env=dict(os.environ, **env))
    if done.returncode:
        print(done.stdout[-4000:] + done.stderr[-4000:])
        sys.exit(1)
    return done.stdout


def build_and_run():
    flags = '-fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc'
    profile = {'LLVM_PROFILE_FILE': f'{FOLDER}/%p.profraw'}
    if not (FOLDER / 'build.ninja').exists():
        run('meson', 'setup', FOLDER, common.ROOT, '-Dbuildtype=debug',
            '-Ddefault_library=static', '-Dtools=disabled', '-Dopencl=disabled',
            '-Dc_args=' + flags, '-Dc_link_args=-fprofile-instr-generate',
            CC='clang-19', **profile)
    run('ninja', '-C', FOLDER, **profile)
    for old in FOLDER.glob('*.profraw'):
        old.unlink()
    run('meson', 'test', '-C', FOLDER, '--no-rebuild', '--suite', 'plenofix:unit',
        **profile)
    run('llvm-profdata-19', 'merge', '-o', FOLDER / 'all.profdata',
        *FOLDER.glob('*.profraw'))
    # Object by object: of an archive llvm-cov misreads members that are not aligned.
    names = run('ar', 't', FOLDER / 'src/libplenofix.a').split()
    objects = [FOLDER / 'src/libplenofix.a.p' / pathlib.Path(n).name for n in names]
    more = [a for o in objects[1:] for a in ('-object', o)]
    return run('llvm-cov-19', 'export', '-format=text',
               f'--instr-profile={FOLDER}/all.profdata', objects[0], *more)


def text_of(path, record):
    """The decision as it stands in the source, blanks folded."""
    line, column, end, stop = record[:4]
    lines = path.read_text().splitlines()[line - 1:end]
    lines[-1] = lines[-1][:stop - 1]
    lines[0] = lines[0][column - 1:]
    return re.sub(r'\s+', ' ', ' '.join(lines)).strip()


def measure(report):
    """Conditions, and (file, line, decision, number not shown)."""
    count, missing = 0, []
    for entry in json.loads(report)['data'][0]['files']:
        path = pathlib.Path(entry['filename'])
        if not path.is_absolute():
            path = common.ROOT / path
        best = {}
        for record in entry.get('mcdc_records', []):
            place = tuple(record[:4])  # of an inline function: the best of its copies
            shown = [c for c in record if isinstance(c, list)][-1]
            old = best.get(place, [False] * len(shown))
            best[place] = [a or b for a, b in zip(old, shown)]
        for place, shown in sorted(best.items()):
            count += len(shown)
            if not all(shown):
                missing.append((path.name, place[0], text_of(path, place),
                                shown.count(False)))
    return count, missing


def argued():
    allowed = {}
    for line in ARGUED.read_text().splitlines():
        if line and not line.startswith('#'):
            name, number, decision, reason = (w.strip() for w in line.split(' | ', 3))
            if reason:
                allowed[name, decision] = int(number)
    return allowed


common.need('clang-19', 'llvm-cov-19', 'meson')
report = (pathlib.Path(sys.argv[2]).read_text() if sys.argv[1:2] == ['--report']
          else build_and_run())
count, missing = measure(report)
left = sum(m[3] for m in missing)
share = 100 * (count - left) / count
print(f'conditions shown to act on their own: {count - left} of {count} ({share:.1f} %)')
if sys.argv[1:] == ['--note']:
    COUNTS.write_text('# Written by .ci/checks/mcdc.py --note\nconditions,shown\n'
                      f'{count},{count - left}\n')
    sys.exit(0)
if sys.argv[1:] == ['--show']:
    for name, line, decision, number in missing:
        print(f'{name}:{line} | {number} | {decision}')
    sys.exit(0)
allowed = argued()
findings = [f'{name}:{line}: {number} of "{decision}" not shown, {allowed.get((name, decision), 0)} argued'
            for name, line, decision, number in missing
            if number > allowed.get((name, decision), 0)]
if share < LEAST:
    findings.append(f'{share:.1f} %, at least {LEAST} %')
common.verdict(findings, 'mcdc')
