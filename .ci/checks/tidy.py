# SPDX-License-Identifier: MIT
"""clang-tidy 14 with .clang-tidy over the core, or over ports and tools.
usage: tidy.py BUILD-FOLDER core|rest     the folder was configured with clang
       tidy.py - FILE.c ..."""
import concurrent.futures
import json
import pathlib
import re
import subprocess
import sys

import common

common.need('clang-tidy-14')
FOLDERS = {'core': ('src',), 'rest': ('port', 'tools')}
folder = pathlib.Path(sys.argv[1])
scope = sys.argv[2]
named = [pathlib.Path(a) for a in sys.argv[2:]] if scope not in FOLDERS else []


def from_database():
    entries = json.loads((folder / 'compile_commands.json').read_text())
    files = {(folder / e['file']).resolve() for e in entries}
    inside = [common.ROOT / d for d in FOLDERS[scope]]
    return sorted(f for f in files if any(d in f.parents for d in inside))


def check(path):
    command = ['clang-tidy-14', '--quiet', f'--config-file={common.ROOT}/.clang-tidy']
    command += [str(path), '--', *common.FLAGS] if named else ['-p', str(folder), str(path)]
    return subprocess.run(command, capture_output=True, text=True)


findings = set()
with concurrent.futures.ThreadPoolExecutor(2) as pool:
    for done in pool.map(check, named or from_database()):
        hits = re.findall(r'^\S+:\d+:\d+: (?:warning|error): .*', done.stdout, re.M)
        findings.update(h.replace(str(common.ROOT) + '/', '') for h in hits)
        if done.returncode and not hits:
            findings.add(done.stderr.strip()[-400:])
common.verdict(sorted(findings), 'clang-tidy')
