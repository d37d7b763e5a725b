#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Zero-mean NCC beside OpenCV: box filters, and cv2.matchTemplate pixel by pixel.

usage: zncc.py LIBPLENOFIX.so [--rounds N] [--sample N]

640x480, 8 bit, window 9, 17 and 64 labels; one process, one thread, the same images,
least processor time, candidates in turns.  matchTemplate takes one pixel a call, its 9x9
window against the 9 x (9 + labels - 1) strip of the other image: --sample pixels (3,000)
spread over the image are timed and the mean is taken for all, in each round; calling it
from Python costs some of that, which is said.  The winners of all three are compared.
Needs numpy and cv2; without them it ends with status 77 (skipped)."""
import argparse
import sys

try:
    import cv2
    import numpy as np
except ImportError as missing:
    print(f'skipped: {missing}')
    sys.exit(77)

import core
from opencv import disparity, pair, wrong

W, H = 640, 480
WINDOW = 9


def box_ncc(left, right, labels):
    """Zero-mean NCC as one writes it with OpenCV: box filters of float32."""
    size = (WINDOW, WINDOW)
    a, b = left.astype(np.float32), right.astype(np.float32)

    def run():
        ma, mb = cv2.boxFilter(a, -1, size), cv2.boxFilter(b, -1, size)
        va = cv2.boxFilter(a * a, -1, size) - ma * ma
        vb = cv2.boxFilter(b * b, -1, size) - mb * mb
        best = np.full(a.shape, -2, np.float32)
        index = np.zeros(a.shape, np.int16)
        for d in range(labels):
            al, br = a[:, d:], b[:, :W - d]
            cov = cv2.boxFilter(al * br, -1, size) - ma[:, d:] * mb[:, :W - d]
            r = cov / np.sqrt(va[:, d:] * vb[:, :W - d] + 1e-6)
            better = r > best[:, d:]
            best[:, d:][better] = r[better]
            index[:, d:][better] = d
        return index
    return run


def templates(left, right, labels, sample):
    """matchTemplate at `sample` pixels: where, and a run that gives their winners."""
    a, b = left.astype(np.uint8), right.astype(np.uint8)
    r = WINDOW // 2
    rng = np.random.default_rng(3)
    xs = rng.integers(labels - 1 + r, W - r, sample)
    ys = rng.integers(r, H - r, sample)
    tops, firsts = (ys - r).tolist(), (xs - r).tolist()

    def run():
        found = []
        for y, x in zip(tops, firsts):
            strip = b[y:y + WINDOW, x - labels + 1:x + WINDOW]
            score = cv2.matchTemplate(strip, a[y:y + WINDOW, x:x + WINDOW],
                                      cv2.TM_CCOEFF_NORMED)
            found.append(labels - 1 - cv2.minMaxLoc(score)[3][0])
        return np.array(found)
    return xs, ys, run


def calls(count):
    """As many calls of matchTemplate that have next to nothing to do."""
    dot = np.zeros((1, 1), np.uint8)

    def run():
        for _ in range(count):
            cv2.minMaxLoc(cv2.matchTemplate(dot, dot, cv2.TM_SQDIFF))
    return run


def case(lib, labels, rounds, sample):
    left, right, truth = pair(W, H, labels, 8)
    ours = core.matcher(lib, left, right, labels, WINDOW, 8, True)
    box = box_ncc(left, right, labels)
    xs, ys, by_template = templates(left, right, labels, sample)
    times = core.least({'ours': ours, 'box': box, 'template': by_template,
                        'calls': calls(sample)}, rounds)
    ns = {k: 1e6 * v / (labels * (sample if k in ('template', 'calls') else W * H))
          for k, v in times.items()}
    found = disparity(ours)
    winner = np.round(found)
    at_sample = np.abs(winner[ys, xs] - by_template()) <= 1
    inner = (slice(4, -4), slice(labels + 4, -4))
    at_box = np.abs(winner - box())[inner] <= 1
    print(f"{labels} labels: ours {ns['ours']:.3f} ns a pixel and disparity; box filters "
          f"{ns['box']:.2f}: {ns['box'] / ns['ours']:.1f} x; matchTemplate "
          f"{ns['template']:.0f}: {ns['template'] / ns['ours']:.0f} x "
          f"({sample} of {W * H} pixels; empty calls are {ns['calls']:.0f} of it)")
    print(f'  wrong by over 1 column {wrong(found, truth):.4f}; within a column of the winner of '
          f'box filters {np.mean(at_box):.5f}, of matchTemplate {np.mean(at_sample):.5f}')


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('library')
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--sample', type=int, default=3000)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    lib = core.Core(args.library).lib
    for labels in (17, 64):
        case(lib, labels, args.rounds, args.sample)


if __name__ == '__main__':
    main()
