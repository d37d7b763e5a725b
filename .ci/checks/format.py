# SPDX-License-Identifier: MIT
"""Layout by clang-format 14 and .clang-format.  usage: format.py [FILE ...]
Mend with: clang-format-14 -i FILE ..."""
import pathlib
import subprocess
import sys

import common

common.need('clang-format-14')
files = [pathlib.Path(a) for a in sys.argv[1:]]
if not files:
    listed = common.run('git', '-C', common.ROOT, 'ls-files', '*.c', '*.h').split()
    files = [common.ROOT / f for f in listed
             if 'planted' not in f and (common.ROOT / f).exists()]
done = subprocess.run(['clang-format-14', '--dry-run', '-Werror', *map(str, files)],
                      capture_output=True, text=True)
wrong = sorted({line.split(':')[0] for line in done.stderr.splitlines()
                if 'error: code should be' in line})
findings = [f'{f}: run clang-format-14 -i on it' for f in wrong]
if done.returncode and not findings:
    findings = done.stderr.splitlines()[:5]
common.verdict(findings, 'format')
