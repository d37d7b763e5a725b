#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Code of the kernels on a Cortex-M7 at -Os, object by object.

usage: kernels_os.py       ends with status 1 over 16 KiB

Kernels: matching by sums of differences and by correlation, its winners and tests, the
gradient, decoding, with their drivers and argument checks.  The stream of raw rows and
its gathering of samples are told apart."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / '.ci/checks'))
import common  # noqa: E402

KERNELS = ('kernels kernels_pair match match_judge engine sweep zncc_columns select winner '
           'texture fuse gradient view').split()
STREAM = 'stream gather gather_fast'.split()
LIMIT = 16 * 1024


def code(folder, stem):
    where = f'{folder}/{stem}.o'
    common.run(common.ARM + 'gcc', *common.ARM_M7, '-std=c99', '-Os', '-Iinclude', '-c',
               str(common.ROOT / 'src' / (stem + '.c')), '-o', where)
    return int(common.run(common.ARM + 'size', where).splitlines()[1].split()[0])


common.need(common.ARM + 'gcc')
with common.scratch() as folder:
    sums = {}
    for name, stems in (('kernels', KERNELS), ('stream', STREAM)):
        sizes = [(stem, code(folder, stem)) for stem in stems]
        for stem, n in sizes:
            print(f'{stem:14} {n:6}')
        sums[name] = sum(n for _, n in sizes)
        print(f'{name:14} {sums[name]:6} bytes in all')
sys.exit(1 if sums['kernels'] > LIMIT else 0)
