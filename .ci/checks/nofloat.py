# SPDX-License-Identifier: MIT
"""No floating point in the core.  usage: nofloat.py [FILE.c ...]

Built for a Cortex-M4 without floating-point unit, every float operation becomes a call
of a helper, and nm sees it.  The words float and double are looked for as well."""
import re
import sys

import common

HELPER = re.compile(r'__aeabi_(c?[fd]|[iul]+2[fd])|__\w*[sdt]f\d?$|__(fix|float)\w*')
WORD = re.compile(r'\b(float|double|_Complex)\b')

named = sys.argv[1:]
findings = []
texts = common.sources_from(named)
if not named:
    texts = texts + sorted(common.ROOT.glob('src/*.h')) + sorted(
        common.ROOT.glob('include/plenofix/*.h'))
for path in texts:
    text = common.strip_comments(path.read_text())
    for n, line in enumerate(text.splitlines(), 1):
        if WORD.search(line):
            findings.append(f'{path.name}:{n}: floating-point type')
common.need(common.ARM + 'gcc')
with common.scratch() as folder:
    objects = common.compile_all(common.ARM + 'gcc', common.sources_from(named),
                                 [*common.ARM_SOFT, '-O2'], folder)
    for line in common.run(common.ARM + 'nm', '-A', '-u', *objects).splitlines():
        name = line.split()[-1]
        if HELPER.match(name):
            findings.append(f'{line.split(":")[0].split("/")[-1]}: calls {name}')
common.verdict(findings, 'nofloat')
