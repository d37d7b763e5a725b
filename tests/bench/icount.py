#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Instructions a cell of the kernels, by valgrind's callgrind.

usage: icount.py PLENOFIX [--check | --update] [--key KEY] [--cases WORD]
       icount.py --report HELD.csv COUNTED.csv

A cell is one sample and one label.  The counts depend on the compiler and its options, so
each line of icount.csv has a key, "gcc VERSION BUILD"; --key names the build, which is
"baseline" without it.  --check fails when a count grew by over 2 % and only reports for
unknown keys; --cases takes those whose name begins with WORD.  --report counts nothing: it
compares two tables and fails as --check would.  Ends with status 77
(skipped) where valgrind is missing."""
import argparse
import csv
import pathlib
import re
import shutil
import subprocess
import sys

TABLE = pathlib.Path(__file__).with_name('icount.csv')
SENSOR = 289 * 193
CASES = {  # name in plenofix bench: functions, cells
    'SAD 640x480 16 labels 9x9': (['plfx_sweep'], 640 * 480 * 16),
    'SAD 640x480 64 labels 9x9': (['plfx_sweep'], 640 * 480 * 64),
    'SAD 640x480 16 labels 21x21': (['plfx_sweep'], 640 * 480 * 16),
    'NCC 640x480 17 labels 9x9': (['plfx_sweep'], 640 * 480 * 17),
    'stream 5 views fast': (['plfx_stream_push', 'plfx_stream_pop'], SENSOR * 17),
    'stream 5 views small': (['plfx_stream_push', 'plfx_stream_pop'], SENSOR * 17),
    'stream 9 views fast': (['plfx_stream_push', 'plfx_stream_pop'], SENSOR * 17),
    'stream 8 views by arms': (['plfx_stream_push', 'plfx_stream_pop'], SENSOR * 17),
    'decode 13x13 views': (['plfx_view_all'], SENSOR * 169),
}


def count(program, name, functions):
    command = ['valgrind', '--tool=callgrind', '--callgrind-out-file=/dev/null',
               *(f'--toggle-collect={f}' for f in functions), program, 'bench', '--rounds', '1',
               '--only', name]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=600)
    return int(re.search(r'Collected : (\d+)', done.stderr).group(1))


def read(path):
    rows = list(csv.DictReader(path.open())) if path.exists() else []
    return {(r['key'], r['case']): float(r['per_cell']) for r in rows}


def verdict(per_cell, limit):
    if limit is None:
        return 'not in icount.csv'
    return f'{"GREW over" if per_cell > 1.02 * limit else "held at"} {limit:.3f}'


def report(held, counted):
    """How many cases grew."""
    limits = read(pathlib.Path(held))
    told = {at: verdict(n, limits.get(at)) for at, n in read(pathlib.Path(counted)).items()}
    for (key, name), text in told.items():
        print(f'{key} {name}: {text}')
    return sum(text.startswith('GREW') for text in told.values())


def main():
    if sys.argv[1:2] == ['--report']:
        sys.exit(1 if report(*sys.argv[2:]) else 0)
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('program')
    parser.add_argument('--key', default='baseline')
    parser.add_argument('--cases', default='')
    parser.add_argument('--check', action='store_true')
    parser.add_argument('--update', action='store_true')
    args = parser.parse_args()
    if not shutil.which('valgrind'):
        print('skipped: no valgrind')
        sys.exit(77)
    version = subprocess.run(['cc', '-dumpfullversion'], capture_output=True, text=True,
                             check=True).stdout.strip()
    key = f'gcc {version} {args.key}'
    known = read(TABLE)
    grown = 0
    for name, (functions, cells) in CASES.items():
        if not name.startswith(args.cases):
            continue
        per_cell = count(args.program, name, functions) / cells
        told = verdict(per_cell, known.get((key, name)))
        grown += told.startswith('GREW')
        print(f'{name:32} {per_cell:8.3f} instructions a cell, {told}')
        known[(key, name)] = per_cell
    if args.update:
        with TABLE.open('w', newline='') as out:
            writer = csv.writer(out, lineterminator='\n')
            writer.writerow(['key', 'case', 'per_cell'])
            writer.writerows((k, n, f'{v:.3f}') for (k, n), v in sorted(known.items()))
    sys.exit(1 if args.check and grown else 0)


if __name__ == '__main__':
    main()
