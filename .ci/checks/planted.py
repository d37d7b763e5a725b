# SPDX-License-Identifier: MIT
"""Every checker catches the violation planted for it.  usage: planted.py [--slow]
Speaks TAP.  A checker that passes, or fails for another reason, is not ok."""
import re
import subprocess
import sys

import common

HERE = common.ROOT / '.ci' / 'checks'
PLANTED = common.ROOT / 'tests' / 'lint' / 'planted'

# what, command, planted files, what the checker must say
CASES = [
    ('no allocation', 'symbols.py', ['allocation.c'], r'needs malloc'),
    ('prefix of globals', 'symbols.py', ['prefix.c'], r'planted_counter has no prefix'),
    ('no writable data', 'symbols.py', ['prefix.c'], r'writable data count'),
    ('no float, by soft-float build', 'nofloat.py', ['floating.c'], r'calls __aeabi_'),
    ('no float, by word', 'nofloat.py', ['float_word.c'], r'floating-point type'),
    ('no recursion', 'calls.py', ['recursion.c'],
     r'recursion: planted_even -> planted_odd -> planted_even'),
    ('no indirect call', 'calls.py', ['pointer.c'], r'plfx_planted: indirect call'),
    ('no array of variable length, by frame', 'calls.py', ['vla.c'],
     r'plfx_planted: frame of unknown size'),
    ('no array of variable length, by warning', 'plain.sh', ['cc', 'vla.c'], r'Werror=vla'),
    ('explicit conversions', 'plain.sh', ['cc', 'conversion.c'], r'Werror=conversion'),
    ('bounded loops', 'loops.py', ['loop.c'], r'loop.c:\d+: loop without'),
    ('bounded stack', 'sizes.py', ['--stack', 'stack.c'], r'plfx_planted: \d+ bytes of stack'),
    ('instructions that grow', 'instructions.py',
     ['--report', 'instructions_old.csv', 'instructions_now.csv'],
     r'golden kernels: 100000 -> 102500'),
    ('instructions a cell that grow', '../../tests/bench/icount.py',
     ['--report', 'icount_held.csv', 'icount_now.csv'], r'planted SAD: GREW over 4.000'),
    ('licence line', 'style.py', ['style.c'], r'licence line'),
    ('no tab', 'style.py', ['style.c'], r'style.c:2: tab'),
    ('no trailing blank', 'style.py', ['style.c'], r'style.c:2: trailing blank'),
    ('no promise of later work', 'style.py', ['style.c'], r'promise of later work'),
    ('no path of one machine', 'style.py', ['style.c'], r'path of one machine'),
    ('no address in a script', 'style.py', ['address.sh'], r'address in a script'),
    ('name that no script defines', 'pynames.py', ['names.py'],
     r'names.py: gone is not defined'),
    ('name that the script beside lacks', 'pynames.py', ['names.py'],
     r'names.py:3: names_beside.py has no WIDTH'),
    ('layout', 'format.py', ['format.c'], r'format.c: run clang-format'),
    ('floors: upward include', 'floors.py', ['floors'],
     r'base.h \(floor 0\) includes include/plenofix/image.h'),
    ('floors: system header', 'floors.py', ['floors'], r'<stdlib.h> is not allowed'),
    ('floors: port into core', 'floors.py', ['floors'], r'port.c: includes src/inner.h'),
    ('floors: new header', 'floors.py', ['floors'], r'novel.h: no floor'),
    ('fault that got through', 'faults.py', ['--report', 'faults.txt'],
     r'power cuts: 3 of 100 got through'),
    ('test named in a document', 'numbers.py', ['numbers.md', 'numbers.h'],
     r'numbers.md:5: test_that_is_gone does not exist'),
    ('bound without a test', 'numbers.py', ['numbers.md', 'numbers.h'],
     r'numbers.md:6: no test holds "offset"'),
    ('format that no document tells', 'numbers.py', ['numbers.md', 'numbers.h'],
     r'numbers.h: silent_q12 is not in numbers.md'),
]
# Checkers that run in .ci/run alone: planted.py --slow
SLOW = [
    ('null pointer, by gcc -fanalyzer', 'analyzer.sh', ['null.c'],
     r'analyzer-null-dereference'),
    ('array bounds, by cppcheck', 'cppcheck.py', ['bounds.c'], r'arrayIndexOutOfBounds'),
    ('unlisted MISRA rule', 'cppcheck.py', ['--misra', 'misra.c'], r'misra-c2012-15\.1'),
    ('braces, by clang-tidy', 'tidy.py', ['-', 'braces.c'],
     r'readability-braces-around-statements'),
    ('no float in a kernel', 'opencl.sh', ['float_kernel.cl'], r'opencl: [1-9]\d* float'),
    ('explicit conversions in a kernel', 'opencl.sh', ['narrow_kernel.cl'],
     r'implicit conversion'),
    ('overflow, by proof', 'proof.py', ['proof.c'], r'signed_overflow\w* not proved'),
    ('overflow, by intervals', 'proof.py', ['--eva', 'proof.c', 'planted_sum'],
     r'signed overflow'),
    ('overrun, by fuzzing', 'fuzz.py', ['--file', 'fuzz.c'], r'heap-buffer-overflow'),
    ('fault that no test sees', 'mutation.py', ['--report', 'mutants.txt'],
     r'planted.c:plfx_planted \| return a \+ b; \| return a - b;: not seen'),
    ('condition without effect, by MC/DC', 'mcdc.py', ['--report', 'mcdc.json'],
     r'mcdc.c:6: 1 of "a && b" not shown'),
    ('recursion, by clang-tidy', 'tidy.py', ['-', 'recursion.c'], r'misc-no-recursion'),
]


def command(checker, args):
    tool = [str(HERE / checker)]
    if checker.endswith('.py'):
        tool.insert(0, sys.executable)
    return tool + [str(PLANTED / a) if (PLANTED / a).exists() else a for a in args]


cases = SLOW if sys.argv[1:] == ['--slow'] else CASES
print(f'1..{len(cases)}')
bad = 0
for number, (what, checker, args, expected) in enumerate(cases, 1):
    done = subprocess.run(command(checker, args), capture_output=True, text=True)
    output = done.stdout + done.stderr
    if done.returncode == common.SKIP:
        print(f'ok {number} - {what} # SKIP {output.strip()}')
    elif done.returncode == 0 or not re.search(expected, output):
        bad += 1
        print(f'not ok {number} - {what}')
        print('# ' + output.strip().replace('\n', '\n# '))
    else:
        print(f'ok {number} - {what}')
sys.exit(1 if bad else 0)
