# SPDX-License-Identifier: MIT
"""gcc's -fcallgraph-info=su of several files as one graph."""
import re

import common

# Stack given to a function that is not ours and whose frame nobody knows, bytes.
FOREIGN = 64


class Graph:
    def __init__(self):
        self.frame, self.calls = {}, {}
        self.indirect, self.dynamic = set(), set()

    def read(self, text):
        for title, label in re.findall(r'node: \{ title: "([^"]+)" label: "([^"]*)"', text):
            size = re.search(r'(\d+) bytes \(([\w,]+)', label)
            if size:
                self.frame[title] = int(size[1])
                self.calls.setdefault(title, set())
                if size[2] != 'static':
                    self.dynamic.add(short(title))
        for source, target in re.findall(
                r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            if target == '__indirect_call':
                self.indirect.add(short(source))
            else:
                self.calls.setdefault(source, set()).add(target)

    def cycles(self):
        """One path a recursion found; depth-first with colours."""
        found, colour = [], {}

        def visit(node, path):
            colour[node] = 1
            for callee in sorted(self.calls.get(node, ())):
                if colour.get(callee) == 1:
                    start = path.index(callee) if callee in path else 0
                    found.append([short(p) for p in path[start:] + [callee]])
                elif callee not in colour:
                    visit(callee, path + [callee])
            colour[node] = 2

        for node in sorted(self.calls):
            if node not in colour:
                visit(node, [node])
        return found

    def worst(self):
        """Deepest stack below each function; needs a graph without recursion."""
        depth = {}

        def below(node):
            if node not in depth:
                own = self.frame.get(node, FOREIGN)
                depth[node] = own + max(
                    (below(c) for c in self.calls.get(node, ())), default=0)
            return depth[node]

        return {short(n): below(n) for n in self.frame}


def short(title):
    return re.split(r'[:/]', title)[-1]


def build(compiler, sources, flags, folder):
    graph = Graph()
    objects = common.compile_all(compiler, sources, [*flags, '-fcallgraph-info=su'], folder)
    for target in objects:
        graph.read(target.with_suffix('.ci').read_text())
    return graph
