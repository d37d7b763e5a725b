# SPDX-License-Identifier: MIT
"""The video port in an emulated arm64 machine with the kernel's vivid driver.

usage: v4l2_guest.py SOURCE-ROOT

Needs qemu-system-aarch64, an arm64 compiler and what tests/port/guest_fetch.sh brings;
skips where one is missing.  Passes on the TAP of tests/port/guest_v4l2.c."""
import os
import pathlib
import shutil
import stat
import subprocess
import sys
import tempfile

QEMU, COMPILER = 'qemu-system-aarch64', 'aarch64-linux-gnu-gcc'
MODULES = ('mc videodev videobuf2-common videobuf2-v4l2 rc-core cec v4l2-dv-timings '
           'v4l2-tpg videobuf2-memops videobuf2-dma-contig videobuf2-vmalloc').split()
VIVID = ('n_devs=1 node_types=0x101 num_inputs=1 input_types=0x03 num_outputs=1 '
         'output_types=0x01')
LIMIT = 180  # seconds; 5 to 13 on an idle machine
SETUP = 'tools/setup ci, or tests/port/guest_fetch.sh'


def skip(why):
    print(f'1..0 # SKIP {why}')
    sys.exit(0)


def member(name, data, mode):
    """A file of a cpio archive in the format that the kernel unpacks."""
    raw = name.encode() + b'\0'
    fields = [0, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(raw), 0]
    head = b'070701' + b''.join(b'%08x' % f for f in fields)
    body = head + raw
    body += b'\0' * (-len(body) % 4) + data
    return body + b'\0' * (-len(body) % 4)


def init_script():
    lines = ['#!/busybox sh',
             '/busybox mount -t proc p /proc', '/busybox mount -t sysfs s /sys',
             '/busybox mount -t devtmpfs d /dev', 'echo 1 > /proc/sys/kernel/printk']
    lines += [f'/busybox insmod /mod/{m}.ko' for m in MODULES]
    lines += [f'/busybox insmod /mod/vivid.ko {VIVID}', '/test', 'echo guest-done $?',
              '/busybox poweroff -f']
    return '\n'.join(lines).encode() + b'\n'


def archive(guest, program):
    folder, run = stat.S_IFDIR | 0o755, stat.S_IFREG | 0o755
    parts = [member(d, b'', folder) for d in ('proc', 'sys', 'dev', 'mod')]
    parts += [member('init', init_script(), run),
              member('busybox', (guest / 'busybox').read_bytes(), run),
              member('test', program.read_bytes(), run)]
    parts += [member(f'mod/{m}.ko', (guest / 'mod' / f'{m}.ko').read_bytes(), run)
              for m in MODULES + ['vivid']]
    return b''.join(parts) + member('TRAILER!!!', b'', 0)


root = pathlib.Path(sys.argv[1])
cache = os.environ.get('XDG_CACHE_HOME') or pathlib.Path.home() / '.cache'
guest = pathlib.Path(cache) / 'plenofix' / 'guest'
for tool in (QEMU, COMPILER):
    if shutil.which(tool) is None:
        skip(f'{tool} is not installed')
if not (guest / 'busybox').exists():
    skip(f'no guest kernel: run {SETUP}')
with tempfile.TemporaryDirectory(prefix='plenofix-') as tmp:
    tmp = pathlib.Path(tmp)
    sources = ['tests/port/guest_v4l2.c', 'port/v4l2/v4l2.c', 'port/v4l2/codes.c',
               'src/raw.c']
    subprocess.run([COMPILER, '-static', '-std=c99', '-O2', f'-I{root}/include',
                    f'-I{root}/port', f'-I{root}/src', *(str(root / s) for s in sources),
                    '-o', str(tmp / 'test')], check=True)
    (tmp / 'initrd').write_bytes(archive(guest, tmp / 'test'))
    try:
        done = subprocess.run(
            [QEMU, '-M', 'virt', '-cpu', 'cortex-a72', '-m', '1024', '-nographic',
             '-nic', 'none', '-no-reboot', '-kernel', str(guest / 'vmlinuz'), '-initrd',
             str(tmp / 'initrd'), '-append', 'console=ttyAMA0 quiet panic=-1'],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            timeout=LIMIT)
        output = done.stdout.decode('utf-8', 'replace')
    except subprocess.TimeoutExpired as late:
        output = (late.stdout or b'').decode('utf-8', 'replace')
        print(f'Bail out! the guest took over {LIMIT} s')
lines = [line.strip('\r') for line in output.split('\n')]
for line in lines:
    if line.startswith(('ok ', 'not ok ', '#', '1..', 'Bail')):
        print(line)
if not any(line.startswith('guest-done') for line in lines):
    print('Bail out! the guest did not finish')
    print('\n'.join('# ' + line for line in lines[-15:]))
    sys.exit(1)
