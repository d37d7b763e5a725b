# SPDX-License-Identifier: MIT
"""Every loop of the core counts, or says why it ends.  usage: loops.py [FILE.c ...]

A `for` that compares its variable and steps it is bounded by what it compares with.  Any
other loop (while, do, a `for` without a step) needs a comment on its line or the line
above that holds the words "at most"."""
import re
import sys

import common

COUNTED = re.compile(
    r'for \(([^;]*);\s*([^;]*(?:<|>|!=)[^;]*);\s*([^;]*(?:\+\+|--|[-+]=|>>=|<<=)[^;]*)\)')

findings = []
named = sys.argv[1:]
paths = common.sources_from(named)
if not named:
    paths = paths + sorted(common.ROOT.glob('src/*.h'))
for path in paths:
    raw = path.read_text().splitlines()
    code = common.strip_comments(path.read_text()).splitlines()
    for n, line in enumerate(code):
        if not re.search(r'\b(?:for|while)\s*\(|\bdo\b\s*\{', line):
            continue
        joined = ' '.join(' '.join(code[n:n + 4]).split())
        start = re.search(r'\bfor \(', joined)
        if re.search(r'\bfor\s*\(', line) and start and COUNTED.match(joined[start.start():]):
            continue
        if re.match(r'\s*}\s*while\b', line):
            continue  # the end of a do, judged at its beginning
        if 'at most' in ' '.join(raw[max(0, n - 1):n + 1]):
            continue
        findings.append(f'{path.name}:{n + 1}: loop without a visible bound')
common.verdict(findings, 'loops')
