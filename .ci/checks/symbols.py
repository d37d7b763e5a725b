# SPDX-License-Identifier: MIT
"""The core needs nothing but three memory functions.  usage: symbols.py [FILE.c ...]

No allocation, no input or output, no global without the prefix plfx_, no writable global
data: the objects of a plain build are read by nm."""
import re
import sys

import common

ALLOWED = re.compile(r'plfx_\w+|memcpy|memset|memmove|_GLOBAL_OFFSET_TABLE_')

common.need('cc', 'nm')
findings = []
with common.scratch() as folder:
    objects = common.compile_all('cc', common.sources_from(sys.argv[1:]), ['-O2'], folder)
    for line in common.run('nm', '-A', *objects).splitlines():
        where, kind, name = re.match(r'.*/(\S+?):\s*\S*\s+(\S) (\S+)$', line).groups()
        if kind == 'U' and not ALLOWED.fullmatch(name):
            findings.append(f'{where}: needs {name}')
        elif kind.isupper() and kind != 'U' and not name.startswith('plfx_'):
            findings.append(f'{where}: global {name} has no prefix')
        elif kind in 'BbDdC':
            findings.append(f'{where}: writable data {name}')
common.verdict(findings, 'symbols')
