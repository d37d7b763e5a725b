# SPDX-License-Identifier: MIT
"""New inputs for every reader and for the streaming driver: libFuzzer with the address,
undefined-behaviour and integer sanitizers (clang 14), from the committed corpora.

usage: fuzz.py SECONDS [NAME ...]            each harness, two at a time
       fuzz.py SECONDS --record [NAME ...]   and note executions in tests/fuzz/record.csv
       fuzz.py --file FILE.c                 a harness of one file, 20 s
       fuzz.py --pack [NAME ...]             least set of inputs found so far into the
                                             corpus, at most 48 KiB a harness

What breaks a harness is left in build-ci/fuzz/found; a mended bug puts it into the
corpus.  Status 1 when something was found."""
import concurrent.futures
import os
import re
import shutil
import struct
import subprocess
import sys

import common

FOLDER = common.ROOT / 'build-ci' / 'fuzz'
CORPUS = common.ROOT / 'tests' / 'fuzz' / 'corpus'
RECORD = common.ROOT / 'tests' / 'fuzz' / 'record.csv'
LIMIT = 48 * 1024
INTEGER = 'implicit-conversion,integer-divide-by-zero,shift,signed-integer-overflow'
ARGS = f'-fsanitize=fuzzer-no-link,{INTEGER} -fno-sanitize-recover=all'


def build():
    env = dict(os.environ, CC='clang-14')
    if not (FOLDER / 'build.ninja').exists():
        run(['meson', 'setup', FOLDER, common.ROOT, '-Db_sanitize=address,undefined',
             '-Db_lundef=false', '-Dbuildtype=debugoptimized', '-Dfuzz=true',
             '-Daravis=disabled', '-Dopencl=disabled', '-Ddefault_library=static',
             '-Dc_args=' + ARGS], env)
    run(['ninja', '-C', FOLDER, *(f'tests/fuzz/fuzz_{n}_new' for n in names())], env)


def run(command, env):
    done = subprocess.run([str(c) for c in command], env=env, capture_output=True,
                          text=True)
    if done.returncode:
        print(done.stdout + done.stderr)
        sys.exit(1)


def names():
    return sorted(p.stem[5:] for p in (common.ROOT / 'tests/fuzz').glob('fuzz_*.c'))


def unpack(name):
    """Inputs of the committed corpus as files beside those found here."""
    folder = FOLDER / 'inputs' / name
    folder.mkdir(parents=True, exist_ok=True)
    data = (CORPUS / f'{name}.bin').read_bytes()
    at = 0
    while at < len(data):
        size, = struct.unpack_from('<I', data, at)
        (folder / f'corpus{at}').write_bytes(data[at + 4:at + 4 + size])
        at += 4 + size
    return folder


def fuzz(name, seconds):
    """Executions, and the report when something broke."""
    folder = unpack(name)
    found = FOLDER / 'found'
    found.mkdir(exist_ok=True)
    done = subprocess.run(
        [str(FOLDER / f'tests/fuzz/fuzz_{name}_new'), f'-max_total_time={seconds}',
         '-max_len=4096', '-timeout=10', '-rss_limit_mb=2048', '-print_final_stats=1',
         '-close_fd_mask=2', f'-artifact_prefix={found}/{name}-', str(folder)],
        capture_output=True, text=True, errors='replace')
    count = re.search(r'number_of_executed_units: *(\d+)', done.stderr)
    return name, int(count[1]) if count else 0, done


def note(results, seconds):
    old = {}
    if RECORD.exists():
        for line in RECORD.read_text().splitlines():
            if not line.startswith(('#', 'harness')):
                name, was, count = line.split(',')
                old[name] = int(was), int(count)
    for name, count in results:
        old[name] = max(old.get(name, (0, 0)), (seconds, count))
    with open(RECORD, 'w') as out:
        out.write('# Longest run of each harness without a finding; written by\n'
                  '# python3 .ci/checks/fuzz.py SECONDS --record\n'
                  'harness,seconds,executions\n')
        for name in sorted(old):
            out.write(f'{name},{old[name][0]},{old[name][1]}\n')


def pack(name):
    folder = unpack(name)
    least = FOLDER / 'least' / name
    shutil.rmtree(least, ignore_errors=True)
    least.mkdir(parents=True)
    subprocess.run([str(FOLDER / f'tests/fuzz/fuzz_{name}_new'), '-merge=1',
                    '-max_len=4096', '-close_fd_mask=2', str(least), str(folder)],
                   capture_output=True)
    data = b''
    files = sorted(least.iterdir(), key=lambda p: (p.stat().st_size, p.name))
    for path in files:
        more = path.read_bytes()
        if len(data) + len(more) + 4 <= LIMIT:
            data += struct.pack('<I', len(more)) + more
    (CORPUS / f'{name}.bin').write_bytes(data)
    print(f'{name}: {len(files)} inputs, {len(data)} bytes')


def single(path):
    with common.scratch() as folder:
        common.run('clang-14', '-g', '-O1', f'-fsanitize=fuzzer,address,undefined,{INTEGER}',
                   path, '-o', folder + '/fuzz')
        done = subprocess.run([folder + '/fuzz', '-max_total_time=20',
                               f'-artifact_prefix={folder}/'], capture_output=True,
                              text=True, errors='replace')
    print(done.stderr[-3000:])
    return 1 if done.returncode else 0


def main(args):
    common.need('clang-14', 'meson', 'ninja')
    if args[:1] == ['--file']:
        return single(args[1])
    named = [a for a in args if a in names()] or names()
    build()
    if '--pack' in args:
        for name in named:
            pack(name)
        return 0
    seconds = int(args[0])
    broken, results = [], []
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get('FUZZ_JOBS', 2))) as pool:
        for name, count, done in pool.map(lambda n: fuzz(n, seconds), named):
            print(f'{name}: {count} executions')
            if done.returncode:
                broken.append(name)
                print(done.stderr[-4000:])
            elif '--record' in args:
                note([(name, count)], seconds)
    print(f'fuzz: {len(named)} harnesses, {seconds} s each, broken: '
          f'{" ".join(broken) or "none"}')
    return 1 if broken else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
