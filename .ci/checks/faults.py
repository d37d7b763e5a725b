# SPDX-License-Identifier: MIT
"""Faults that the tests make on purpose: how many were tried, how many got through.

usage: faults.py BUILD          run the tests that count them; none may get through, and
                                as many as in tests/faults.csv must be tried
       faults.py BUILD --note   and write tests/faults.csv
       faults.py --report FILE  judge an output made before

A test says: # count: WHAT, N tried, M missed"""
import pathlib
import re
import sys

import common

TABLE = common.ROOT / 'tests' / 'faults.csv'
TESTS = ['test_lut', 'test_packet', 'port/test_port_faults', 'port/test_port_store',
         'port/test_port_v4l2']
LINE = re.compile(r'^# count: (.+), (\d+) tried, (\d+) missed$', re.M)


def counts(text):
    """What -> (tried, missed)."""
    total = {}
    for what, tried, missed in LINE.findall(text):
        was = total.get(what, (0, 0))
        total[what] = was[0] + int(tried), was[1] + int(missed)
    return total


def told():
    rows = [line.split(',') for line in TABLE.read_text().splitlines()
            if not line.startswith('#')][1:] if TABLE.exists() else []
    return {what: (int(tried), int(missed)) for what, tried, missed in rows}


if sys.argv[1] == '--report':
    now = counts(pathlib.Path(sys.argv[2]).read_text())
else:
    folder = pathlib.Path(sys.argv[1]) / 'tests'
    now = counts(''.join(common.run(folder / t) for t in TESTS))
if '--note' in sys.argv:
    TABLE.write_text('# Faults made by tests; written by faults.py BUILD --note\n'
                     'fault,tried,missed\n' +
                     ''.join(f'{w},{n},{m}\n' for w, (n, m) in sorted(now.items())))
findings = [f'{w}: {m} of {n} got through' for w, (n, m) in now.items() if m]
findings += [f'{w}: {n} tried, {now.get(w, (0, 0))[0]} now; faults.py BUILD --note'
             for w, (n, _) in told().items() if now.get(w, (0, 0))[0] < n]
if not now:
    findings.append('no test has counted anything')
for what, (tried, missed) in sorted(now.items()):
    print(f'{what}: {tried} tried, {missed} missed')
common.verdict(findings, 'faults')
