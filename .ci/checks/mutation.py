# SPDX-License-Identifier: MIT
"""Mutation score of the kernels: of faults put into them, how many do the tests see?

usage: mutation.py [N]            N mutants (default 80) of the kernels, drawn with a fixed
                                  seed; at least 95 % must be seen, the rest are argued in
                                  tests/mutants.txt
       mutation.py --report FILE  judge a list of survivors made before

Mutants are made by universalmutator (from PyPI, into build-ci/venv) and tried in a copy of
the tree under build-ci/mutants.  One whose object code equals the original's is no
mutant.  A line of tests/mutants.txt: file | line as it is | line as mutated | reason."""
import pathlib
import random
import shutil
import subprocess
import sys

import common

FOLDER = common.ROOT / 'build-ci' / 'mutants'
VENV = common.ROOT / 'build-ci' / 'venv'
ARGUED = common.ROOT / 'tests' / 'mutants.txt'
KERNELS = ['depth.c', 'fuse.c', 'kernels.c', 'refocus.c', 'sample.c', 'select.c',
           'texture.c', 'winner.c', 'winner_row.c']
TESTS = ['select', 'fuse', 'depth', 'refocus', 'sweep', 'golden', 'frame', 'lanes']
LEAST, SEED = 0.95, 20


def tool():
    if not (VENV / 'bin/mutate').exists():
        common.run(sys.executable, '-m', 'venv', VENV)
        common.run(VENV / 'bin/pip', '-q', 'install', 'universalmutator==1.14.1')
    return VENV / 'bin/mutate'


def prepare():
    """A copy of the tree, built; returns it."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    tree = FOLDER / 'tree'
    for name in common.run('git', '-C', common.ROOT, 'ls-files').split('\n'):
        if name and (common.ROOT / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(common.ROOT / name, tree / name)
    common.run('meson', 'setup', tree / 'build', tree, '-Dtools=disabled',
               '-Dopencl=disabled', '-Daravis=disabled', '-Ddefault_library=static',
               '-Doptimization=1')
    common.run('ninja', '-C', tree / 'build', *(f'tests/test_{t}' for t in TESTS))
    return tree


def mutants(tree):
    """(file, mutated text), all of them."""
    every = []
    for name in KERNELS:
        folder = FOLDER / 'made' / name
        folder.mkdir(parents=True)
        common.run(tool(), tree / 'src' / name, 'c', '--noCheck', '--mutantDir', folder)
        every += [(name, p) for p in sorted(folder.glob('*.c'))]
    return every


def objects(tree, name, folder):
    target = pathlib.Path(folder) / 'o'
    done = subprocess.run(['cc', *common.FLAGS, '-O2', '-c', str(tree / 'src' / name), '-o',
                           str(target)], capture_output=True)
    return target.read_bytes() if done.returncode == 0 else None


def verdict(tree, name):
    """'seen', or 'missed', of the mutant that lies in the tree."""
    done = subprocess.run(['ninja', '-C', str(tree / 'build'),
                           *(f'tests/test_{t}' for t in TESTS)], capture_output=True)
    if done.returncode:
        return 'seen'  # a compiler refuses it
    for t in TESTS:
        try:
            done = subprocess.run([str(tree / 'build/tests' / f'test_{t}')],
                                  capture_output=True, timeout=60)
        except subprocess.TimeoutExpired:
            return 'seen'
        if done.returncode:
            return 'seen'
    return 'missed'


def changed(original, mutant):
    for a, b in zip(original.splitlines(), mutant.splitlines()):
        if a != b:
            return a.strip(), b.strip()
    return '', ''


def run(count):
    tree = prepare()
    every = mutants(tree)
    random.Random(SEED).shuffle(every)
    tried, survivors = 0, []
    with common.scratch() as folder:
        plain = {n: objects(tree, n, folder) for n in KERNELS}
        for name, path in every:
            if tried == count:
                break
            source = tree / 'src' / name
            original = source.read_text()
            source.write_text(path.read_text())
            code = objects(tree, name, folder)
            if code is not None and code != plain[name]:
                tried += 1
                if verdict(tree, name) == 'missed':
                    survivors.append((name, *changed(original, path.read_text())))
                    print('missed: ' + ' | '.join(survivors[-1]), flush=True)
            source.write_text(original)
    return tried, survivors


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


args = sys.argv[1:]
tried, survivors = report(args[1]) if args[:1] == ['--report'] else run(
    int(args[0]) if args else 80)
known = argued()
findings = [f'{" | ".join(s)}: not seen by a test, not argued' for s in survivors
            if s not in known]
score = (tried - len(findings)) / tried
print(f'mutants: {tried} tried, {tried - len(survivors)} seen, '
      f'{len(survivors) - len(findings)} argued, score {score:.3f}')
if score >= LEAST:
    for f in findings:
        print(f)
    findings = []
common.verdict(findings, 'mutation')
