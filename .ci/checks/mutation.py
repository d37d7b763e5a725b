# SPDX-License-Identifier: MIT
"""Mutation score of the kernels: of faults put into them, how many do the tests see?

usage: mutation.py [--note] [SET ...]   a sample of each set of kernels: of each at least
                                  95 % must be seen or argued in tests/mutants.txt;
                                  --note: the counts into tests/mutation.csv
       mutation.py SET N FIRST    N mutants of a set, from number FIRST (0) of the order
       mutation.py --report FILE  judge a list of survivors made before

Mutants are made by universalmutator (from PyPI, into build-ci/venv) and tried in a copy of
the tree under build-ci/mutants.  One whose object code equals the original's is no
mutant.  Their order is that of a hash of file, function, line and mutated line: a change
elsewhere leaves the sample as it is.  A line of tests/mutants.txt:
file:function | line as it is | line as mutated | reason."""
import collections
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys

import common

FOLDER = common.ROOT / 'build-ci' / 'mutants'
VENV = common.ROOT / 'build-ci' / 'venv'
ARGUED = common.ROOT / 'tests' / 'mutants.txt'
# Sources, tests that may see a mutant, mutants of the sample.
SETS = {
    'matching': (['depth.c', 'fuse.c', 'kernels.c', 'kernels_pair.c', 'refocus.c',
                  'sample.c', 'select.c', 'texture.c', 'winner.c', 'winner_row.c', 'zncc.c',
                  'zncc_columns.c', 'zncc_lanes.c', 'zncc_rows.c'],
                 ['select', 'fuse', 'depth', 'refocus', 'winner', 'sweep', 'sweep_edges',
                  'golden', 'frame', 'lanes'], 120),
    'frames': (['arms.c', 'gradient.c', 'match_judge.c', 'median.c', 'refine.c', 'sgm.c',
                'view.c', 'view_run.c'],
               ['gradient', 'view', 'winner', 'golden', 'frame_edges', 'sweep',
                'stream_edges', 'limits', 'frame'], 60),
}
LEAST = 0.95
COUNTS = common.ROOT / 'tests' / 'mutation.csv'


def tool():
    if not (VENV / 'bin/mutate').exists():
        common.run(sys.executable, '-m', 'venv', VENV)
        common.run(VENV / 'bin/pip', '-q', 'install', 'universalmutator==1.14.1')
    return VENV / 'bin/mutate'


def prepare(tests):
    """A copy of the tree, built; returns it."""
    os.chdir(common.ROOT)
    shutil.rmtree(FOLDER, ignore_errors=True)
    tree = FOLDER / 'tree'
    for name in common.run('git', '-C', common.ROOT, 'ls-files').split('\n'):
        if name and (common.ROOT / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(common.ROOT / name, tree / name)
    common.run('meson', 'setup', tree / 'build', tree, '-Dtools=disabled',
               '-Dopencl=disabled', '-Daravis=disabled', '-Ddefault_library=static',
               '-Doptimization=1')
    common.run('ninja', '-C', tree / 'build', *(f'tests/test_{t}' for t in tests))
    return tree


def mutants(tree, sources):
    """(hash, file, where, line, mutated line, mutated text) of all, in order."""
    every, seen = [], collections.Counter()
    os.chdir(FOLDER)  # where the tool leaves its files
    for name in sources:
        folder = FOLDER / 'made' / name
        folder.mkdir(parents=True)
        common.run(tool(), tree / 'src' / name, 'c', '--noCheck', '--mutantDir', folder)
        original = (tree / 'src' / name).read_text()
        # numbers of mutants are made without leading zeros
        for path in sorted(folder.glob('*.c'), key=lambda p: (len(p.name), p.name)):
            text = path.read_text()
            where = changed(name, original, text)
            seen[where] += 1
            key = ' | '.join(where) + f' | {seen[where]}'
            every.append((hashlib.sha256(key.encode()).hexdigest(), name, where, text))
    return sorted(every)


def objects(tree, name, folder):
    target = pathlib.Path(folder) / 'o'
    done = subprocess.run(['cc', *common.FLAGS, '-O2', '-c', str(tree / 'src' / name), '-o',
                           str(target)], capture_output=True)
    return target.read_bytes() if done.returncode == 0 else None


def verdict(tree, tests):
    """'seen', or 'missed', of the mutant that lies in the tree."""
    done = subprocess.run(['ninja', '-C', str(tree / 'build'),
                           *(f'tests/test_{t}' for t in tests)], capture_output=True)
    if done.returncode:
        return 'seen'  # a compiler refuses it
    for t in tests:
        try:
            done = subprocess.run([str(tree / 'build/tests' / f'test_{t}')],
                                  capture_output=True, timeout=60)
        except subprocess.TimeoutExpired:
            return 'seen'
        if done.returncode:
            return 'seen'
    return 'missed'


def changed(name, original, mutant):
    """file:function, line, mutated line."""
    function = ''
    for a, b in zip(original.splitlines(), mutant.splitlines()):
        head = re.match(r'(?:[a-z]\w*[ *]+)+(\w+)\(', a)
        function = head[1] if head else function
        if a != b:
            return f'{name}:{function}', a.strip(), b.strip()
    return name, '', ''


def run(which, count=None, first=0):
    sources, tests, sample = SETS[which]
    count = count or sample
    tree = prepare(tests)
    tried, survivors = 0, []
    with common.scratch() as folder:
        plain = {n: objects(tree, n, folder) for n in sources}
        for _, name, where, text in mutants(tree, sources):
            source = tree / 'src' / name
            original = source.read_text()
            source.write_text(text)
            code = objects(tree, name, folder)
            if code is not None and code != plain[name]:
                tried += 1
                if tried > first and verdict(tree, tests) == 'missed':
                    survivors.append(where)
                    print(f'missed ({tried}): ' + ' | '.join(where), flush=True)
            source.write_text(original)
            if tried == first + count:
                break
    return tried - first, survivors


def argued():
    known = set()
    for line in ARGUED.read_text().splitlines():
        if line and not line.startswith('#'):
            name, was, now, reason = (w.strip() for w in line.split(' | ', 3))
            if reason:
                known.add((name, was, now))
    return known


def report(path):
    head, *rest = pathlib.Path(path).read_text().splitlines()
    return int(head), [tuple(w.strip() for w in line.split(' | ')) for line in rest]


def judge(name, tried, survivors):
    """Counts of a set, and what is wrong with it."""
    known = argued()
    new = [f'{" | ".join(s)}: not seen by a test, not argued' for s in survivors
           if s not in known]
    score = (tried - len(new)) / tried
    counts = name, tried, tried - len(survivors), len(survivors) - len(new)
    print(f'{name}: {tried} tried, {counts[2]} seen, {counts[3]} argued, '
          f'score {score:.3f}')
    if score >= LEAST:
        for line in new:
            print(line)
        new = []
    return counts, new


def note(rows):
    COUNTS.write_text('# Faults put into the kernels; written by\n'
                      '# python3 .ci/checks/mutation.py --note\n'
                      'set,tried,seen,argued\n' +
                      ''.join(','.join(map(str, row)) + '\n' for row in rows))


args = [a for a in sys.argv[1:] if a != '--note']
if args[:1] == ['--report']:
    results = [judge('report', *report(args[1]))]
elif len(args) == 3 and args[1].isdigit():
    results = [judge(args[0], *run(args[0], int(args[1]), int(args[2])))]
else:
    results = [judge(name, *run(name)) for name in args or SETS]
    if '--note' in sys.argv:
        note([counts for counts, _ in results])
common.verdict([f for _, findings in results for f in findings], 'mutation')
