#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Least-squares gradient slopes of five views beside the same with numpy and OpenCV.

usage: gradient.py LIBPLENOFIX.so [--rounds N]

One process, one thread, the same views, least processor time, candidates in turns.  The
rival is the same estimator in float32: derivatives by the matched 3-tap pair through
cv2.sepFilter2D, products by numpy, window sums by cv2.boxFilter, slope and confidence by
numpy; once more without the confidence, and once with plain central differences, which
are cheaper and read slopes low.  Ours is the whole plfx_gradient(): slope, confidence and
borders.  Needs numpy and cv2; without them it ends with status 77 (skipped)."""
import argparse
import sys

try:
    import cv2
    import numpy as np
except ImportError as missing:
    print(f'skipped: {missing}')
    sys.exit(77)

import core

WINDOW, BITS = 9, 12
SMOOTH = np.array([59, 138, 59], np.float32) / 256
DIFFER = np.array([-109, 0, 109], np.float32) / 256


def scene(w, h, seed=1):
    """Views centre, -u, +u, -v, +v of a slanted plane of 60 waves, noise of 4 counts."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    truth = -0.2 + 0.4 * x / w
    length, turn = rng.uniform(6, 30, 60), rng.uniform(0, np.pi, 60)
    waves = np.stack([np.cos(turn), np.sin(turn), rng.uniform(0, 1, 60) * length]) / length
    views = []
    for u, v in ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)):
        seen = np.zeros((h, w), np.float32)
        for a, b, phase in waves.T:
            seen += np.cos(2 * np.pi * (a * (x - truth * u) + b * (y - truth * v) + phase))
        noisy = 2048 + 90 * seen + 4 * rng.standard_normal((h, w))
        views.append(np.clip(np.round(noisy), 0, 4095).astype(np.uint16))
    return views, truth


def solve(ix, iu, iy, iv, confidence):
    def box(a):
        return cv2.boxFilter(a, -1, (WINDOW, WINDOW))
    xx, yy = box(ix * ix), box(iy * iy)
    slope = -(box(ix * iu) + box(iy * iv)) / (xx + yy + 1e-9)
    if not confidence:
        return slope, None
    xy = box(ix * iy)
    least = (xx + yy - np.sqrt((xx - yy)**2 + 4 * xy * xy)) / 2
    return slope, least / (least + 4.0**(BITS - 6))


def matched(views, confidence):
    c, l, r, t, b = [a.astype(np.float32) for a in views]

    def filtered(a, along, across):
        return cv2.sepFilter2D(a, -1, along, across)
    side, mid = SMOOTH[0], SMOOTH[1]
    ix = filtered(side * (l + r) + mid * c, DIFFER, SMOOTH)
    iy = filtered(side * (t + b) + mid * c, SMOOTH, DIFFER)
    iu = filtered(DIFFER[2] * (r - l), SMOOTH, SMOOTH)
    iv = filtered(DIFFER[2] * (b - t), SMOOTH, SMOOTH)
    return solve(ix, iu, iy, iv, confidence)


def plain(views):
    c, l, r, t, b = [a.astype(np.float32) for a in views]
    ix, iy = np.zeros_like(c), np.zeros_like(c)
    ix[:, 1:-1] = (c[:, 2:] - c[:, :-2]) / 2
    iy[1:-1] = (c[2:] - c[:-2]) / 2
    return solve(ix, (r - l) / 2, iy, (b - t) / 2, False)


def case(lib, w, h, rounds):
    views, truth = scene(w, h)
    settings = dict(method=core.GRADIENT, window=WINDOW, bits=BITS, labels=3, lo=-65536,
                    hi=65536, at=[(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)])
    ours = core.Planned(lib, views, **settings)
    alone = core.Planned(lib, views, **settings)
    alone.map.conf = None
    rivals = {'same, with confidence': lambda: matched(views, True),
              'same, slope alone': lambda: matched(views, False),
              'central differences': lambda: plain(views)}
    times = core.least({'ours, with confidence': ours, 'ours, slope alone': alone, **rivals},
                       rounds)
    inner = (slice(8, -8), slice(8, -8))
    found = ours.slopes()[inner]
    apart = np.nanmax(np.abs(found - matched(views, False)[0][inner]))
    if not np.array_equal(ours.slope, alone.slope):
        raise RuntimeError('the confidence changes slopes')
    print(f'{w}x{h}: median error {np.nanmedian(np.abs(found - truth[inner])):.4f}, '
          f'farthest from float32 {apart:.5f}')
    for name in ('ours, with confidence', 'ours, slope alone'):
        print(f'  {name:22} {times[name]:7.2f} ms, {1e6 * times[name] / (w * h):.1f} ns a lens')
    for name, run in rivals.items():
        like = 'ours, ' + ('with confidence' if 'with' in name else 'slope alone')
        error = np.median(np.abs(run()[0] - truth)[inner])
        print(f'  {name:22} {times[name]:7.2f} ms: {times[name] / times[like]:5.2f} x; '
              f'median error {error:.4f}')


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('library')
    parser.add_argument('--rounds', type=int, default=9)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    lib = core.Core(args.library).lib
    for w, h in ((core.LENSES_X, core.LENSES_Y), (640, 480)):
        case(lib, w, h, args.rounds)


if __name__ == '__main__':
    main()
