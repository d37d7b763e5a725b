# SPDX-License-Identifier: MIT
"""What the checkers share: where the tree is, which files are the core, how to stop."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIP = 77  # Meson's exit status for a skipped test
FLAGS = ['-std=c99', '-I' + str(ROOT / 'include'), '-I' + str(ROOT / 'src')]
ARM = 'arm-none-eabi-'
ARM_M7 = ['-mcpu=cortex-m7', '-mthumb', '-mfloat-abi=hard', '--specs=picolibc.specs']
ARM_SOFT = ['-mcpu=cortex-m4', '-mthumb', '-mfloat-abi=soft', '--specs=picolibc.specs']

# Programs for the emulated board that talk to the host: memory, start, output.
ARM_BOARD = ['--oslib=semihost', '--crt0=semihost', '-Wl,--gc-sections',
             '-Wl,--defsym=__flash=0', '-Wl,--defsym=__flash_size=4M',
             '-Wl,--defsym=__ram=0x20000000', '-Wl,--defsym=__ram_size=4M']


def core_sources():
    """The core: src/*.c, nothing below."""
    return sorted((ROOT / 'src').glob('*.c'))


def tracked():
    """Files of the project, where git is absent all but what builds leave."""
    done = subprocess.run(['git', '-C', str(ROOT), 'ls-files', '-z'],
                          capture_output=True)
    if done.returncode == 0:
        return [ROOT / f for f in done.stdout.decode().split('\0') if f]
    return [p for p in ROOT.rglob('*') if p.is_file() and not any(
        part.startswith('build') or part == '.git' for part in p.parts)]


def sources_from(args):
    """Files named on the command line, else the core."""
    return [pathlib.Path(a) for a in args] or core_sources()


def need(*tools):
    for tool in tools:
        if shutil.which(tool) is None:
            print(f'skipped: {tool} is not installed (tools/setup ci)')
            sys.exit(SKIP)


def run(*args):
    """Output of a command; its messages and status 1 when it fails."""
    done = subprocess.run([str(a) for a in args], capture_output=True, text=True)
    if done.returncode:
        print(done.stdout + done.stderr)
        print('failed: ' + ' '.join(str(a) for a in args))
        sys.exit(1)
    return done.stdout


def emulate(program, *args, options=()):
    """Output of a program on an emulated Cortex-M7; ends with status 1 when it fails."""
    semihosting = 'enable=on,target=native' + ''.join(f',arg={a}' for a in args)
    done = subprocess.run(
        ['qemu-system-arm', '-M', 'mps2-an500', '-display', 'none', '-monitor', 'none',
         '-serial', 'none', *options, '-semihosting-config', semihosting,
         '-kernel', program],
        capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=200)
    if done.returncode:
        print(done.stdout + done.stderr)
        sys.exit(1)
    return done.stdout + done.stderr


def compile_all(compiler, sources, flags, folder):
    """One object a source, two at a time; returns their paths in order."""
    objects, running = [], []
    for source in sources:
        target = pathlib.Path(folder) / (source.stem + '.o')
        objects.append(target)
        command = [compiler, *FLAGS, *flags, '-c', str(source), '-o', str(target)]
        running.append((source, subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)))
        if len(running) == 2:
            finish(running.pop(0))
    for pair in running:
        finish(pair)
    return objects


def finish(pair):
    source, process = pair
    output = process.communicate()[0]
    if process.returncode:
        print(output)
        print(f'{source}: does not compile')
        sys.exit(1)


def scratch():
    return tempfile.TemporaryDirectory(prefix='plenofix-')


def strip_comments_keep_includes(text):
    """C text with comments blanked, strings kept."""
    return re.sub(r'/\*.*?\*/', lambda m: re.sub(r'[^\n]', ' ', m.group(0)), text,
                  flags=re.S)


def strip_comments(text):
    """C text with comments and string contents blanked, line numbers kept."""
    def blank(match):
        s = match.group(0)
        if s.startswith('/'):
            return re.sub(r'[^\n]', ' ', s)
        return s[0] + s[0]
    return re.sub(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'',
                  blank, text, flags=re.S)


# Parts of the core that a microcontroller links on their own, and their objects on an M7.
PARTS = {
    'frame.h': r'(arms|frame|frame_flags|median|preset|refine|sgm|sigma|sigma_map|viewcheck|'
               r'winner_row)$',
    'arms in stream.h': r'arms_stream$',
    'structural motion': r'(roi|modal|packet)(_|$)|ln$',
    'drift.h': r'drift(_|$)',
}


def part_of(stem):
    """The part that an object belongs to; 'core' for depth itself."""
    return next((part for part, stems in PARTS.items() if re.match(stems, stem)), 'core')


def verdict(findings, what):
    """Print findings and leave: status 1 if there are any."""
    for f in findings:
        print(f)
    print(f'{what}: {len(findings)} finding' + ('' if len(findings) == 1 else 's'))
    sys.exit(1 if findings else 0)
