# SPDX-License-Identifier: MIT
"""cppcheck over core, ports and tools, and its MISRA add-on over the core.

usage: cppcheck.py [FILE.c ...]           bugs, portability, performance
       cppcheck.py --misra [FILE.c ...]   rules of MISRA C:2012 not listed in
                                          .ci/misra.txt with a reason"""
import collections
import fnmatch
import re
import subprocess
import sys

import common

common.need('cppcheck')
misra = '--misra' in sys.argv
named = [common.pathlib.Path(a) for a in sys.argv[1:] if not a.startswith('--')]
TEMPLATE = '{file}:{line}: {id}: {message}'


def cppcheck(paths, *options):
    done = subprocess.run(
        ['cppcheck', '--quiet', '--std=c99', '--platform=unix64', '-j2',
         f'-I{common.ROOT}/include', f'-I{common.ROOT}/src', f'-I{common.ROOT}/tools',
         f'-I{common.ROOT}/port', '--suppress=missingIncludeSystem',
         '--suppress=unusedStructMember', '--suppress=unmatchedSuppression',
         '--suppress=preprocessorErrorDirective', '--suppress=variableScope',
         '--suppress=shadowFunction', '--suppress=unreadVariable',
         # bpp_of[] refuses the formats that group_of[] does not hold
         '--suppress=arrayIndexOutOfBoundsCond:*/raw.c', '--inline-suppr',
         f'--template={TEMPLATE}', *options, *map(str, paths)],
        capture_output=True, text=True)
    prefix = str(common.ROOT) + '/'
    return sorted({line.replace(prefix, '') for line in done.stderr.splitlines()
                   if re.match(r'\S+:\d+: ', line)})


def deviations():
    rules = []
    for line in (common.ROOT / '.ci' / 'misra.txt').read_text().splitlines():
        if line.strip() and not line.startswith('#'):
            rule, files, reason = line.split(None, 2)
            rules.append((rule, files, reason))
    return rules


# C99 declares at the head of a block; clang's analyser and valgrind judge reads of unset
# variables better than cppcheck 2.10, which follows no pointer into a call.
def bugs():
    core = named or common.core_sources()
    found = cppcheck(core, '--enable=warning,style,performance,portability')
    if not named:
        outer = sorted(p for d in ('port', 'tools') for p in (common.ROOT / d).rglob('*.c'))
        if outer:
            found += cppcheck(outer, '--enable=warning,performance,portability',
                              '--suppress=uninitvar', '--suppress=uninitStructMember',
                              '--suppress=compareBoolExpressionWithInt')
    common.verdict(found, 'cppcheck')


def rules():
    # One process: the add-on needs whole-program knowledge for its system rules.
    found = [f for f in cppcheck(named or common.core_sources(), '--addon=misra', '-j1')
             if 'misra-c2012-' in f]
    listed, used, left = deviations(), collections.Counter(), []
    for f in found:
        path, rule = f.split(':')[0], re.search(r'misra-c2012-(\d+\.\d+)', f)[1]
        hit = next((d for d in listed if d[0] == rule and fnmatch.fnmatch(path, d[1])), None)
        if hit:
            used[hit] += 1
        else:
            left.append(f)
    for d in listed:
        print(f'deviation {d[0]:5} {d[1]:16} {used[d]:4} times')
    common.verdict(left, 'misra')


rules() if misra else bugs()
