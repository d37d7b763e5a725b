# SPDX-License-Identifier: MIT
"""A shared library exports plfx_ names only.  usage: exports.py LIBRARY.so"""
import sys

import common

common.need('nm')
names = [line.split()[-1] for line in
         common.run('nm', '-D', '--defined-only', sys.argv[1]).splitlines()]
findings = [f'exported: {n}' for n in names if not n.startswith('plfx_')]
if not names:
    findings.append('nothing is exported')
common.verdict(findings, 'exports')
