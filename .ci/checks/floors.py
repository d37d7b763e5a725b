# SPDX-License-Identifier: MIT
"""A file includes only lower floors.  usage: floors.py [ROOT]

Public headers stand on the floors below; a source of the core stands on the floor of the
header of its name.  Internal headers of src/ have the floor of what they include.
port/ sees include/ alone; src/*.c never sees port.h or cl.h; nothing below tools/
includes from tools/.  The core uses three system headers."""
import pathlib
import re
import sys

import common

FLOORS = [['base', 'version'], ['image', 'raw'], ['fuse', 'lut'], ['view'], ['plan'],
          ['sweep', 'gradient', 'depth', 'refocus', 'roi', 'modal', 'packet',
           'drift'],
          ['stream', 'frame', 'viewcheck'], ['preset'], ['plenofix'], ['port', 'cl']]
FLOOR = {name: n for n, names in enumerate(FLOORS) for name in names}
SYSTEM = {'stdint.h', 'stddef.h', 'string.h'}

root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else common.ROOT
findings = []


def includes(path):
    text = common.strip_comments_keep_includes(path.read_text())
    return re.findall(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', text, re.M)


def resolve(path, name):
    for base in (path.parent, root / 'include', root / 'src', root / 'tools', root):
        if (base / name).exists():
            return (base / name).resolve().relative_to(root.resolve()).as_posix()
    return None


def floor(rel, seen=()):
    """Floor of a public header, or the highest that an internal header pulls in."""
    if rel.startswith('include/plenofix/'):
        return FLOOR.get(pathlib.PurePosixPath(rel).stem)
    if rel in seen:
        findings.append('cycle: ' + ' -> '.join(seen + (rel,)))
        return 0
    inner = [resolve(root / rel, n) for q, n in includes(root / rel) if q == '"']
    return max([floor(i, seen + (rel,)) or 0 for i in inner if i], default=0)


def check_core(rel, path):
    stem = path.stem
    own = FLOOR.get(stem)
    if rel.startswith('include/') and own is None:
        findings.append(f'{rel}: no floor; give it one in .ci/checks/floors.py')
        return
    for quote, name in includes(path):
        if quote == '<':
            if name not in SYSTEM:
                findings.append(f'{rel}: <{name}> is not allowed in the core')
            continue
        target = resolve(path, name)
        if target is None:
            findings.append(f'{rel}: "{name}" not found')
            continue
        if not target.startswith(('include/plenofix/', 'src/')):
            findings.append(f'{rel}: includes {target}, outside the core')
            continue
        public = target.startswith('include/plenofix/')
        if public and pathlib.PurePosixPath(target).stem == stem:
            continue
        height = floor(target)
        if own is None:
            limit = FLOOR['plenofix'] - 1
        elif public:
            limit = own - 1
        else:
            limit = own
        if height > limit:
            findings.append(f'{rel} (floor {own}) includes {target} (floor {height})')


def check_outer(rel, path, allowed):
    for quote, name in includes(path):
        target = resolve(path, name) if quote == '"' else None
        if target and not target.startswith(allowed):
            findings.append(f'{rel}: includes {target}; allowed: {", ".join(allowed)}')


for path in sorted(root.glob('**/*.[ch]')):
    rel = path.relative_to(root).as_posix()
    if rel.startswith('include/') or re.fullmatch(r'src/[^/]+\.[ch]', rel):
        check_core(rel, path)
    elif rel.startswith('src/cl/'):
        check_outer(rel, path, ('include/', 'src/'))
    elif rel.startswith('port/'):
        check_outer(rel, path, ('include/', 'port/'))
    elif rel.startswith('tools/'):
        check_outer(rel, path, ('include/', 'port/', 'tools/'))
common.verdict(findings, 'floors')
