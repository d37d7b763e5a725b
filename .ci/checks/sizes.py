# SPDX-License-Identifier: MIT
"""Code, data, stack, structures and workspaces of the core on a Cortex-M7, built at -O2.

usage: sizes.py            compare with tests/sizes.csv (2 %, at least 8 bytes)
       sizes.py --limits   the budgets alone: 40 KiB of code for depth, 28 KiB for
                           structural motion, 1 KiB of stack
       sizes.py --update   write tests/sizes.csv anew, on purpose
       sizes.py --stack FILE.c   the stack budget of one file"""
import re
import sys

import callgraph
import common

TABLE = common.ROOT / 'tests' / 'sizes.csv'
CODE_LIMITS = {  # bytes of text, by part
    'core': 40 * 1024,
    'frame.h': 24 * 1024,  # it wants a frame's memory
    'arms in stream.h': 6 * 1024,  # with rows of frame.h; -DPLFX_STREAM_ARMS=0: neither
    'structural motion': 28 * 1024,
    'drift.h': 12 * 1024,
}
STACK_LIMIT = 1024       # bytes, deepest path below a public function
COMPILER = common.ARM + 'gcc'
BUILD = [*common.ARM_M7, '-O2', '-ffunction-sections', '-fdata-sections']
UPDATE = 'python3 .ci/checks/sizes.py --update'


def public_functions():
    text = ''.join(h.read_text() for h in (common.ROOT / 'include').glob('*/*.h'))
    return set(re.findall(r'\b(plfx_\w+)\s*\(', common.strip_comments(text)))


def core_headers():
    every = sorted((common.ROOT / 'include').glob('*/*.h'))
    return [h for h in every if h.stem not in ('port', 'cl')]


def structures():
    names = []
    for header in core_headers():
        names += re.findall(r'typedef struct (plfx_\w+) \{', header.read_text())
    return names


def measure_objects(objects):
    for line in common.run(common.ARM + 'size', *objects).splitlines()[1:]:
        text, data, bss, _, _, name = line.split()
        stem = name.split('/')[-1].removesuffix('.o')
        for kind, value in (('text', text), ('data', data), ('bss', bss)):
            yield kind, stem, int(value)


def measure_structures(folder):
    source = folder + '/sizes_probe.c'
    with open(source, 'w') as out:
        for header in core_headers():
            out.write(f'#include "plenofix/{header.name}"\n')
        for name in structures():
            out.write(f'extern char probe_{name}[sizeof({name})];\n')
            out.write(f'char probe_{name}[sizeof({name})];\n')
    probe = common.compile_all(COMPILER, [common.pathlib.Path(source)],
                               common.ARM_M7, folder)
    for line in common.run(common.ARM + 'nm', '-S', *probe).splitlines():
        words = line.split()
        if len(words) == 4 and words[3].startswith('probe_'):
            yield 'struct', words[3].removeprefix('probe_'), int(words[1], 16)


def measure_workspaces(objects, folder):
    """Of a large frame, as the program prints them on the target."""
    program = folder + '/workspaces.elf'
    source = common.ROOT / 'tests/target/m7/workspaces.c'
    main = common.compile_all(COMPILER, [source], BUILD, folder)
    common.run(COMPILER, *BUILD, *common.ARM_BOARD, *main, *objects, '-o', program)
    for name, value in re.findall(r'^(\w+) (\d+)$', common.emulate(program), re.M):
        yield 'workspace', name, int(value)


def measure():
    rows = []
    with common.scratch() as folder:
        sources = common.core_sources()
        graph = callgraph.build(COMPILER, sources, BUILD, folder)
        objects = [common.pathlib.Path(folder) / (s.stem + '.o') for s in sources]
        rows += measure_objects(objects)
        public = public_functions()
        rows += [('stack', n, d) for n, d in graph.worst().items() if n in public]
        rows += measure_structures(folder)
        rows += measure_workspaces(objects, folder)
    return {(kind, name): value for kind, name, value in rows}


def budgets(now):
    code = dict.fromkeys(CODE_LIMITS, 0)
    for (kind, name), v in now.items():
        if kind == 'text':
            code[common.part_of(name)] += v
    worst = max(((v, n) for (k, n), v in now.items() if k == 'stack'), default=(0, '-'))
    print(', '.join(f'{part} {v} of {CODE_LIMITS[part]}' for part, v in code.items()) +
          f' bytes; deepest stack {worst[0]} of {STACK_LIMIT} bytes ({worst[1]})')
    findings = [f'{n}: {v} bytes of stack, at most {STACK_LIMIT}'
                for (k, n), v in sorted(now.items()) if k == 'stack' and v > STACK_LIMIT]
    findings += [f'code of {part}: {v} bytes, at most {CODE_LIMITS[part]}'
                 for part, v in code.items() if v > CODE_LIMITS[part]]
    return findings


def compiler_version():
    return common.run(COMPILER, '-dumpfullversion').strip()


def write(now):
    order = ['text', 'data', 'bss', 'stack', 'struct', 'workspace']
    with open(TABLE, 'w') as out:
        out.write(f'# Cortex-M7, {COMPILER} {compiler_version()} -O2; bytes\n')
        out.write('# text, data, bss: an object of the core; stack: deepest path below a\n'
                  '# public function; struct: a public structure; workspace: of a large\n'
                  '# frame (tests/target/m7/workspaces.c).  Written by ' +
                  f'{UPDATE}\n')
        out.write('kind,name,bytes\n')
        for (kind, name), value in sorted(
                now.items(), key=lambda i: (order.index(i[0][0]), i[0][1])):
            if value or kind not in ('data', 'bss'):
                out.write(f'{kind},{name},{value}\n')


def read():
    old, version = {}, ''
    for line in TABLE.read_text().splitlines():
        if line.startswith('# Cortex'):
            version = line.split()[3]
        elif not line.startswith('#') and not line.startswith('kind,'):
            kind, name, value = line.split(',')
            old[kind, name] = int(value)
    return old, version


def compare(now):
    old, version = read()
    findings = []
    for key in sorted(set(old) | set(now)):
        kind, name = key
        was, value = old.get(key, 0), now.get(key, 0)
        if key not in old and (value or kind not in ('data', 'bss')):
            findings.append(f'{kind} {name}: new, {value} bytes; record it: {UPDATE}')
        elif key in old and key not in now:
            findings.append(f'{kind} {name}: gone, was {was} bytes; record it: {UPDATE}')
        elif abs(value - was) > max(8, was * 0.02):
            findings.append(f'{kind} {name}: {was} -> {value} bytes; if meant: {UPDATE}')
    if version != compiler_version():
        print(f'table of compiler {version}, this is {compiler_version()}: report only')
        for f in findings:
            print(f)
        return []
    return findings


common.need(COMPILER)
mode = sys.argv[1] if len(sys.argv) > 1 else ''
if mode == '--stack':
    with common.scratch() as folder:
        graph = callgraph.build(COMPILER, [common.pathlib.Path(sys.argv[2])], BUILD, folder)
        over = {n: d for n, d in graph.worst().items() if d > STACK_LIMIT}
    common.verdict([f'{n}: {d} bytes of stack, at most {STACK_LIMIT}'
                    for n, d in sorted(over.items())], 'stack')
common.need('qemu-system-arm')
now = measure()
if mode == '--update':
    write(now)
    print(f'{len(now)} values written to tests/sizes.csv')
findings = budgets(now)
if mode == '':
    findings += compare(now)
common.verdict(findings, 'sizes')
