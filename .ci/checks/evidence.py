# SPDX-License-Identifier: MIT
"""Results of gates into tests/evidence.csv: gate, status, seconds, commit.

usage: evidence.py GATE,STATUS,SECONDS ...

.ci/run --full writes every gate; .ci/run --note NAME ... those gates alone, so that a
small machine can gather the table piece by piece.  A gate keeps its last result and the
commit that it belongs to; a tree with changes is marked +."""
import subprocess
import sys

import common

TABLE = common.ROOT / 'tests' / 'evidence.csv'


def git(*args):
    done = subprocess.run(['git', '-C', str(common.ROOT), *args], capture_output=True,
                          text=True)
    return done.stdout.strip()


rows = {}
if TABLE.exists():
    for line in TABLE.read_text().splitlines():
        if not line.startswith(('#', 'gate,')):
            rows[line.split(',')[0]] = line
commit = git('rev-parse', '--short', 'HEAD') + (
    '+' if git('status', '--porcelain', '--untracked-files=no', '--', ':!tests/evidence.csv')
    else '')
for result in sys.argv[1:]:
    rows[result.split(',')[0]] = f'{result},{commit}'
with open(TABLE, 'w') as out:
    out.write('# Gates of .ci/run, their last status (0: passed) and the commit tried;\n'
              '# written by .ci/run --full and .ci/run --note NAME ...\n'
              'gate,status,seconds,commit\n')
    for name in rows:
        out.write(rows[name] + '\n')
