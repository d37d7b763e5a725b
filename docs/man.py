# SPDX-License-Identifier: MIT
"""Make the manual page from a template and the program's own help.

usage: man.py TEMPLATE OUTPUT PROGRAM"""
import pathlib
import re
import subprocess
import sys


def ask(program, *args):
    done = subprocess.run([program, *args], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f'{program} {" ".join(args)}: status {done.returncode}\n{done.stderr}')
    return done.stdout


def escape(line):
    line = line.replace('\\', '\\e').replace('-', '\\-')
    return '\\&' + line if line.startswith(('.', "'")) else line


def commands(program):
    """(name, about) of each command that the help lists."""
    return re.findall(r'^  (\S+) {2,}(\S.*)$', ask(program, 'help'), re.M)


def section(program, name, about):
    yield f'.SS {escape(name)}'
    yield escape(about[0].upper() + about[1:] + '.')
    if name != 'help':
        yield '.PP\n.nf'
        yield from (escape(s) for s in ask(program, name, '--help').rstrip().split('\n'))
        yield '.fi'


def main(template, output, program):
    version = ask(program, '--version').split()[-1]
    parts = [line for name, about in commands(program)
             for line in section(program, name, about)]
    page = pathlib.Path(template).read_text()
    page = page.replace('@VERSION@', version).replace('@COMMANDS@', '\n'.join(parts))
    pathlib.Path(output).write_text(page)


main(*sys.argv[1:])
