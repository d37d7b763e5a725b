# SPDX-License-Identifier: MIT
"""Layout and wording that no compiler checks.  usage: style.py [FILE ...]

Every tracked text file: no tab (but in make-like files), no carriage return, no trailing
blank, one newline at the end, no path of a developer's machine.  C: 88 columns, licence
line first, no word that promises later work.  Scripts and build files: no address."""
import pathlib
import re
import sys

import common

C = {'.c', '.h', '.cl'}
SCRIPT = {'.py', '.sh', '.build', '.wrap', '.ini', ''}
BINARY = {'.png', '.plut', '.pfm', '.tif', '.tiff', '.bin', '.xz', '.raw'}
MACHINE = re.compile(r'(?<![\w.])/(?:home/\w+|root|Users/\w+|work|mnt|media)\b')
ADDRESS = re.compile(r'\b(?:https?|ftp|git|ssh)://')
LATER = re.compile(r'\b(?:TODO|FIXME|XXX|HACK|stub(?:bed)?|placeholder)\b', re.I)
WIDTH = 88


def check(path, rel):
    data = path.read_bytes()
    if path.suffix in BINARY or b'\0' in data[:4096]:
        return
    text = data.decode('utf-8', 'replace')
    lines = text.split('\n')
    if '\ufffd' in text:
        yield 1, 'not UTF-8'
    if text and (not text.endswith('\n') or text.endswith('\n\n')):
        yield len(lines), 'not exactly one newline at the end'
    if path.suffix in C and not re.match(r'/\* SPDX-License-Identifier: MIT', text):
        yield 1, 'does not start with the licence line'
    if path.suffix in {'.py', '.sh'} or text.startswith('#!'):
        if 'SPDX-License-Identifier: MIT' not in '\n'.join(lines[:2]):
            yield 1, 'no licence line in the first two lines'
    for n, line in enumerate(lines, 1):
        if '\r' in line:
            yield n, 'carriage return'
        if line.endswith((' ', '\t')) and path.suffix != '.md':
            yield n, 'trailing blank'
        if '\t' in line and path.suffix in C | SCRIPT - {''}:
            yield n, 'tab'
        if path.suffix in C and len(line) > WIDTH:
            yield n, f'{len(line)} columns, at most {WIDTH}'
        if path.name == 'style.py':
            continue
        if MACHINE.search(line):
            yield n, 'path of one machine'
        if path.suffix in C | SCRIPT and LATER.search(line):
            yield n, 'promise of later work: ' + LATER.search(line)[0]
        if path.suffix in SCRIPT and path.name != 'LICENSE' and ADDRESS.search(line):
            yield n, 'address in a script'


findings = []
planted = common.ROOT / 'tests' / 'lint' / 'planted'
for path in [pathlib.Path(a).resolve() for a in sys.argv[1:]] or common.tracked():
    if not path.is_file() or (not sys.argv[1:] and planted in path.parents):
        continue
    rel = path.relative_to(common.ROOT) if common.ROOT in path.parents else path
    findings += [f'{rel}:{n}: {what}' for n, what in check(path, rel)]
common.verdict(findings, 'style')
