#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Seconds and memory of the whole command on a 16-megapixel white frame of 12 bits.

usage: calibration_time.py PLENOFIX [ROUNDS]

Draws 289 x 193 soft discs 17 px apart with noise of 0.4 % of full scale, writes PNG and
TIFF, and runs "plenofix calibrate" on each: the least CPU time of ROUNDS (3) and the peak
of memory beside three frames' worth (asked: 1.0 s, three frames).  Status 1 when missed, 77
without numpy or PIL."""
import os
import pathlib
import sys
import tempfile

try:
    import numpy as np
    from PIL import Image
except ImportError as e:
    print(f'skipped: {e}')
    sys.exit(77)

COLUMNS, ROWS, PITCH = 289, 193, 16.97
WIDTH, HEIGHT = 4904, 3280
KINDS = 'png', 'tif'


def white():
    """Discs with an edge one pixel soft, 12 bits, at any phase of the pixel grid."""
    def off(n, count):
        at = (np.arange(n) - 6.3) / PITCH
        return (at - np.clip(np.rint(at), 0, count - 1)) * PITCH
    r = np.hypot(off(WIDTH, COLUMNS)[None, :], off(HEIGHT, ROWS)[:, None])
    light = 200 + 3000 / (1 + np.exp((r - 7.0) / 0.5))
    rng = np.random.default_rng(5)
    light += rng.normal(0, 0.004 * 4095, light.shape)
    return np.clip(np.rint(light), 0, 4095).astype(np.uint16)


def draw(folder):
    """In a process of its own: a child's peak would hold its parent's."""
    if os.fork() == 0:
        image = Image.fromarray(white())
        for kind in KINDS:
            image.save(pathlib.Path(folder, f'white.{kind}'))
        os._exit(0)
    if os.wait()[1]:
        sys.exit('drawing failed')


def cost(command):
    """CPU seconds and peak MiB of one run."""
    out = os.open(os.devnull, os.O_WRONLY)
    pid = os.posix_spawn(command[0], command, os.environ,
                         file_actions=[(os.POSIX_SPAWN_DUP2, out, 1)])
    os.close(out)
    _, status, used = os.wait4(pid, 0)
    if status:
        sys.exit(f'{" ".join(command)}: status {status}')
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program = os.path.abspath(sys.argv[1])
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    frames = 3 * 2 * WIDTH * HEIGHT / 2**20
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        draw(folder)
        for kind in KINDS:
            frame = f'{folder}/white.{kind}'
            runs = [cost([program, 'calibrate', frame, '--bits', '12', '-o',
                          f'{folder}/t.plut']) for _ in range(rounds)]
            seconds, peak = min(r[0] for r in runs), max(r[1] for r in runs)
            bad = seconds > 1.0 or peak > frames
            missed += bad
            print(f'{kind}: {seconds:.2f} s of CPU, peak {peak:.0f} MiB (three frames '
                  f'{frames:.0f}){"  MISSED" if bad else ""}')
        table = os.path.getsize(f'{folder}/t.plut')
        print(f'table: {table / COLUMNS / ROWS:.2f} bytes a lens, gains in it')
    sys.exit(missed != 0)


if __name__ == '__main__':
    main()
