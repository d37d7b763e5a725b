#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Multiplications that the reference set-up of structural sensing executes on a
Cortex-M7 at -O2, counted under QEMU: 24 regions of 7 x 9 lenses, 25 views.

usage: multiplies.py [--limit MILLIONS]

Counts every multiply instruction (mul, mla, smull, smlal ...; the dual ones twice) of a
measurement, as the difference between three and one of them, for a frame that stands
still, is moved by 0.3 and by 0.8 of a lens, and for darkness.  A product of two 64-bit
numbers takes three such instructions, and is counted so, as are those of addresses.  At
200 Hz; exit status 1 when standing still is over the limit (60), 77 where a tool is
missing."""
import argparse
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / '.ci/checks'))
import common  # noqa: E402

BUILD = [*common.ARM_M7, '-O2', '-ffunction-sections']
LINK = ['--oslib=semihost', '--crt0=semihost', '-Wl,--gc-sections', '-Wl,--defsym=__flash=0',
        '-Wl,--defsym=__flash_size=4M', '-Wl,--defsym=__ram=0x20000000',
        '-Wl,--defsym=__ram_size=4M']
RATE = 200
CASES = {'still': '0', 'moved by 0.3 lens': '30', 'moved by 0.8 lens': '80', 'dark': 'dark'}
JUDGED = ('still',)
SINGLE = r'mul|mla|mls|umull|umlal|umaal|smull|smlal|smul[bt][bt]|smla[bt][bt]|smlal[bt][bt]|' \
         r'smulw[bt]|smlaw[bt]|smmulr?|smmlar?|smmlsr?'
DUAL = r'smuadx?|smusdx?|smladx?|smlsdx?|smlaldx?|smlsldx?'


def build(folder):
    objects = common.compile_all(common.ARM + 'gcc',
                                 [*common.core_sources(), ROOT / 'tests/target/m7/regions.c'],
                                 BUILD, folder)
    program = f'{folder}/regions.elf'
    common.run(common.ARM + 'gcc', *BUILD, *LINK, *objects, '-o', program)
    common.run('cc', '-shared', '-fPIC', '-O2', '-fvisibility=hidden',
               ROOT / 'tests/bench/count_plugin.c', '-o', f'{folder}/count.so')
    return program


def multiplies(program):
    """Address: multiplications, 1 or 2, of each multiply instruction."""
    found = {}
    for line in common.run(common.ARM + 'objdump', '-d', program).splitlines():
        m = re.match(r'\s*([0-9a-f]+):\t[0-9a-f ]+\t(\w+?)s?(?:\.[nw])?\t', line)
        if m and re.fullmatch(SINGLE, m.group(2)):
            found[int(m.group(1), 16)] = 1
        elif m and re.fullmatch(DUAL, m.group(2)):
            found[int(m.group(1), 16)] = 2
    return found


def execute(folder, program, *args):
    """Count at each address, and what the program said."""
    semihosting = 'enable=on,target=native' + ''.join(f',arg={a}' for a in args)
    done = subprocess.run(
        ['qemu-system-arm', '-M', 'mps2-an500', '-display', 'none', '-monitor', 'none',
         '-serial', 'none', '-plugin', f'{folder}/count.so,each={folder}/each',
         '-semihosting-config', semihosting, '-kernel', program],
        capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=300)
    if done.returncode:
        sys.exit(f'exit status {done.returncode}: {done.stdout}{done.stderr}')
    counts = {int(a, 16): int(n) for a, n in map(str.split, open(f'{folder}/each'))}
    return counts, done.stdout.strip() or done.stderr.split('\n')[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--limit', type=float, default=60.0)
    args = parser.parse_args()
    common.need(common.ARM + 'gcc', common.ARM + 'objdump', 'qemu-system-arm', 'cc')
    over = False
    with common.scratch() as folder:
        program = build(folder)
        weight = multiplies(program)
        for name, case in CASES.items():
            once, _ = execute(folder, program, case, '1')
            thrice, said = execute(folder, program, case, '3')
            every = {a: (n - once.get(a, 0)) / 2 for a, n in thrice.items()}
            products = sum(n * weight.get(a, 0) for a, n in every.items())
            rate = products * RATE / 1e6
            judged = name in JUDGED
            over = over or (judged and rate > args.limit)
            print(f'{name}, {said} of 24: {products:.0f} multiplications of '
                  f'{sum(every.values()):.0f} instructions a frame; {rate:.1f} million a second'
                  f'{f" (limit {args.limit:g})" if judged else ""}')
    sys.exit(over)


if __name__ == '__main__':
    main()
