# SPDX-License-Identifier: MIT
"""No recursion, no indirect call, no frame of unknown size in the core.
usage: calls.py [FILE.c ...]

Read from gcc's call graph of an -O0 build: the optimiser folds tail calls and would hide
a recursion.  Outgoing arguments are part of the frame, so that struct arguments do not make
it dynamic."""
import sys

import callgraph
import common

common.need('gcc')
with common.scratch() as folder:
    graph = callgraph.build('gcc', common.sources_from(sys.argv[1:]),
                        ['-O0', '-maccumulate-outgoing-args'], folder)
findings = [f'{f}: indirect call' for f in sorted(graph.indirect)]
findings += [f'{f}: frame of unknown size' for f in sorted(graph.dynamic)]
findings += ['recursion: ' + ' -> '.join(path) for path in graph.cycles()]
common.verdict(findings, 'calls')
