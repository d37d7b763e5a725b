# SPDX-License-Identifier: MIT
"""Names that the Python scripts use exist.  usage: pynames.py [FILE.py ...]

Every tracked script: it parses, its global names are defined in it or built in, and what
it takes from a script beside it (`from core import X`, `core.X`) stands there.  Nothing
is run, so that scripts whose packages are absent are checked as well."""
import ast
import builtins
import symtable
import sys

import common

KNOWN = set(dir(builtins)) | {'__file__', '__name__', '__doc__'}


def scripts():
    return [p for p in common.tracked() if 'planted' not in p.parts
            and (p.suffix == '.py' or first_line(p).endswith('python3'))]


def first_line(path):
    if path.suffix or not path.is_file():
        return ''
    return path.read_bytes().split(b'\n')[0].decode('utf-8', 'replace')


def defined(table):
    """Names that a module binds, by `global` in a function as well."""
    names = {s.get_name() for s in table.get_symbols()
             if s.is_assigned() or s.is_imported() or s.is_namespace()}
    return names.union(*[taken(t) for t in table.get_children()])


def taken(table):
    own = {s.get_name() for s in table.get_symbols() if s.is_declared_global()
           and s.is_assigned()}
    return own.union(*[taken(t) for t in table.get_children()])


def globals_of(table):
    """Names that a scope and those within it look up in the module."""
    top = table.get_type() == 'module'
    names = {s.get_name() for s in table.get_symbols() if s.is_referenced()
             and (s.is_global() or top)}
    return names.union(*[globals_of(t) for t in table.get_children()])


def module(path):
    text = path.read_text()
    return ast.parse(text, str(path)), symtable.symtable(text, str(path), 'exec')


def beside(path, name):
    other = path.parent / f'{name}.py'
    return defined(module(other)[1]) if other.exists() else None


def foreign(path, tree):
    """(line, script beside, name) of all that is taken from scripts beside this one."""
    aliases = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            aliases.update({a.asname or a.name: a.name for a in node.names})
        if isinstance(node, ast.ImportFrom) and node.level == 0:
            yield from ((node.lineno, node.module, a.name) for a in node.names)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.value.id in aliases:
                yield node.lineno, aliases[node.value.id], node.attr


def check(path):
    name = path.relative_to(common.ROOT)
    try:
        tree, table = module(path)
    except SyntaxError as wrong:
        return [f'{name}:{wrong.lineno}: {wrong.msg}']
    found = [f'{name}: {n} is not defined'
             for n in sorted(globals_of(table) - defined(table) - KNOWN)]
    for line, other, wanted in foreign(path, tree):
        names = beside(path, other)
        if names is not None and wanted not in names:
            found.append(f'{name}:{line}: {other}.py has no {wanted}')
    return found


paths = [common.pathlib.Path(a).resolve() for a in sys.argv[1:]] or scripts()
common.verdict([f for p in paths for f in check(p)], 'pynames')
