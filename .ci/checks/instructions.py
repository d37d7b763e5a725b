# SPDX-License-Identifier: MIT
"""Instructions on a Cortex-M7 at -O2, counted under QEMU, the same on every machine.

usage: instructions.py            compare with tests/instructions.csv (2 %, both ways)
       instructions.py --update   write it anew, on purpose
       instructions.py --report OLD NOW   compare two tables made before

Rows: `golden`, an object of the core during one run of every golden stage; `band`, a row
of lenses (10 sensor rows, 420 wide) of the goldens' scene through a stream, 5 views, 12
labels, window 5, maps popped."""
import collections
import re
import sys

import common

TABLE = common.ROOT / 'tests' / 'instructions.csv'
UPDATE = 'python3 .ci/checks/instructions.py --update'
COMPILER = common.ARM + 'gcc'
BUILD = [*common.ARM_M7, '-O2', '-ffunction-sections', '-I' + str(common.ROOT / 'tests')]
BANDS = 33
LEAST = 1000  # instructions: fewer say nothing


def build(folder):
    """Program, plug-in, and where each object's functions lie: (start, end, object)."""
    tests = [*(common.ROOT / 'tests/golden').glob('*.c'),
             common.ROOT / 'tests/target/m7/counts.c']
    core = common.core_sources()
    objects = common.compile_all(COMPILER, [*core, *sorted(tests)], BUILD, folder)
    common.run(COMPILER, *BUILD, *common.ARM_BOARD, *objects, '-o', folder + '/counts.elf',
               f'-Wl,-Map={folder}/counts.map')
    common.run('cc', '-shared', '-fPIC', '-O2', '-fvisibility=hidden',
               common.ROOT / 'tests/bench/count_plugin.c', '-o', folder + '/count.so')
    names = {s.stem for s in core}
    text = open(folder + '/counts.map').read()
    text = text[text.index('Linker script and memory map'):]
    ranges = []
    for start, size, name in re.findall(
            r'^ \.text\S*\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) \S*?(\w+)\.o$', text, re.M):
        if name in names and int(size, 16):
            ranges.append((int(start, 16), int(start, 16) + int(size, 16), name))
    return ranges


def execute(folder, *args):
    """All instructions, and those at each address."""
    each = folder + '/each'
    common.emulate(folder + '/counts.elf', *args,
                   options=['-plugin', f'{folder}/count.so,each={each}'])
    return [(int(a, 16), int(n)) for a, n in map(str.split, open(each))]


def by_object(counts, ranges):
    sums = collections.Counter()
    for address, n in counts:
        for start, end, name in ranges:
            if start <= address < end:
                sums[name] += n
    return sums


def measure():
    rows = {}
    with common.scratch() as folder:
        ranges = build(folder)
        for name, n in by_object(execute(folder, 'stages'), ranges).items():
            if n >= LEAST:
                rows['golden', name] = n
        for profile in ('fast', 'small'):
            once, twice = (sum(n for _, n in execute(folder, profile, str(rounds)))
                           for rounds in (1, 2))
            rows['band', f'stream {profile}'] = (twice - once) // BANDS
    return rows


def version():
    return common.run(COMPILER, '-dumpfullversion').strip()


def write(now):
    with open(TABLE, 'w') as out:
        out.write(f'# Cortex-M7, {COMPILER} {version()} -O2; instructions executed.\n'
                  '# golden: an object of the core, every golden stage once; band: a row\n'
                  f'# of lenses through a stream.  Written by {UPDATE}\n'
                  'kind,name,instructions\n')
        for (kind, name), n in sorted(now.items()):
            out.write(f'{kind},{name},{n}\n')


def read(path):
    rows, made_by = {}, ''
    for line in path.read_text().splitlines():
        if line.startswith('# Cortex'):
            made_by = line.split()[3]
        elif not line.startswith(('#', 'kind,')):
            kind, name, n = line.split(',')
            rows[kind, name] = int(n)
    return rows, made_by


def compare(old, now):
    for key in sorted(set(old) | set(now)):
        was, n = old.get(key, 0), now.get(key, 0)
        if abs(n - was) > max(LEAST, was * 0.02):
            yield f'{" ".join(key)}: {was} -> {n} instructions; if meant: {UPDATE}'


if sys.argv[1:2] == ['--report']:
    tables = [read(common.pathlib.Path(p))[0] for p in sys.argv[2:4]]
    common.verdict(list(compare(*tables)), 'instructions')
common.need(COMPILER, 'qemu-system-arm', 'cc')
now = measure()
if '--update' in sys.argv:
    write(now)
    print(f'{len(now)} values written to tests/instructions.csv')
old, made_by = read(TABLE)
findings = list(compare(old, now))
print(', '.join(f'{n} a band of {name}' for (kind, name), n in sorted(now.items())
                if kind == 'band'))
if made_by != version():
    print(f'table of compiler {made_by}, this is {version()}: report only')
    for f in findings:
        print(f)
    findings = []
common.verdict(findings, 'instructions')
