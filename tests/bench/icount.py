#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Instructions a cell of the kernels, by valgrind's callgrind.

usage: icount.py PLENOFIX [--check | --update] [--key KEY] [--cases WORD]

A cell is one sample and one label.  The counts depend on the compiler and its options, so
each line of icount.csv has a key, "gcc VERSION BUILD"; --key names the build, which is
"baseline" without it.  --check fails when a count grew by over 2 % and only reports for
unknown keys; --cases takes those whose name begins with WORD.  Ends with status 77
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


def main():
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
    rows = list(csv.DictReader(TABLE.open())) if TABLE.exists() else []
    known = {(r['key'], r['case']): float(r['per_cell']) for r in rows}
    grown = 0
    for name, (functions, cells) in CASES.items():
        if not name.startswith(args.cases):
            continue
        per_cell = count(args.program, name, functions) / cells
        limit = known.get((key, name))
        verdict = 'not in icount.csv'
        if limit is not None:
            verdict = f'held at {limit:.3f}'
            if per_cell > 1.02 * limit:
                verdict = f'GREW over {limit:.3f}'
                grown += 1
        print(f'{name:32} {per_cell:8.3f} instructions a cell, {verdict}')
        known[(key, name)] = per_cell
    if args.update:
        with TABLE.open('w', newline='') as out:
            writer = csv.writer(out, lineterminator='\n')
            writer.writerow(['key', 'case', 'per_cell'])
            writer.writerows((k, n, f'{v:.3f}') for (k, n), v in sorted(known.items()))
    sys.exit(1 if args.check and grown else 0)


if __name__ == '__main__':
    main()
