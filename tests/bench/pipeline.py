#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Raw frame to disparity, 16 megapixels, 17 slopes, window 9: the streaming driver beside
the same written with OpenCV from Python.

usage: pipeline.py LIBPLENOFIX.so [--rounds N]

4904 x 3280 pixels of 12 bits, 289 x 193 lenses; 5 and 9 views along u; one process, one
thread, the same frame, least processor time.  OpenCV's way: a view by cv2.remap, a
fractional shift by cv2.warpAffine, cv2.absdiff summed over the views, one cv2.boxFilter a
slope, numpy's argmin and a parabola; its maps, matrices and images are made before.  Ours
also judges borders and range ends, and its time holds the 400 calls through ctypes.  Both
are set beside the truth.  Needs numpy and cv2; without them it ends with status 77, which
Meson counts as skipped."""
import argparse
import sys

try:
    import cv2
    import numpy as np
except ImportError as missing:
    print(f'skipped: {missing}')
    sys.exit(77)

import core

LABELS, WINDOW, TOP = 17, 9, 10000 / 65536


def truth():
    """Slope of every lens: a plane."""
    i, j = np.meshgrid(np.arange(core.LENSES_X), np.arange(core.LENSES_Y))
    return -0.1 + 0.2 * (i / core.LENSES_X + j / core.LENSES_Y) / 2


def texture():
    rng = np.random.default_rng(1)
    t = np.zeros((core.LENSES_Y, core.LENSES_X), np.float32)
    for k in (2, 4, 8):
        small = rng.standard_normal((core.LENSES_Y // k + 2, core.LENSES_X // k + 2))
        t += cv2.resize(small.astype(np.float32), (core.LENSES_X, core.LENSES_Y),
                        interpolation=cv2.INTER_CUBIC)
    return t


def picture():
    """Each pixel sees the plane through the nearest lens: V_u(i) = C(i - D u)."""
    y, x = np.mgrid[0:core.SENSOR_H, 0:core.SENSOR_W].astype(np.float32)
    a = core.PITCH * np.exp(1j * core.TURN)
    at = ((x - core.ORIGIN[0]) + 1j * (y - core.ORIGIN[1])) / a
    i = np.clip(np.round(at.real), 0, core.LENSES_X - 1).astype(np.float32)
    j = np.clip(np.round(at.imag), 0, core.LENSES_Y - 1).astype(np.float32)
    offset = (at - (i + 1j * j)) * core.PITCH
    slope = -0.1 + 0.2 * (i / core.LENSES_X + j / core.LENSES_Y) / 2
    seen = cv2.remap(texture(), (i - slope * offset.real).astype(np.float32),
                     (j - slope * offset.imag).astype(np.float32), cv2.INTER_CUBIC,
                     borderMode=cv2.BORDER_REFLECT)
    seen = (seen - seen.min()) / (seen.max() - seen.min())
    noise = np.random.default_rng(2).standard_normal(seen.shape)
    return np.clip(np.round(200 + 3600 * seen + noise), 0, 4095).astype(np.uint16)


class ByOpenCV:
    def __init__(self, frame, offsets):
        self.frame, self.offsets = frame, offsets
        self.maps = []
        for u in offsets:
            p = (core.centres() + np.array([u * np.cos(core.TURN), u * np.sin(core.TURN)]))
            self.maps.append([np.ascontiguousarray(p[..., k].astype(np.float32))
                              for k in (0, 1)])
        self.slopes = np.linspace(-TOP, TOP, LABELS)
        shape = (core.LENSES_Y, core.LENSES_X)
        self.moves = [[np.array([[1, 0, d * u], [0, 1, 0]]) for u in offsets]
                      for d in self.slopes]
        self.views = [np.empty(shape, np.uint16) for _ in offsets]
        self.moved, self.cost, self.total = (np.empty(shape, np.uint16) for _ in range(3))
        self.costs = np.empty((LABELS, *shape), np.float32)

    def sum_of(self, label):
        """Absolute differences of all views from the reference, moved as at a label."""
        ref, size = len(self.views) // 2, (core.LENSES_X, core.LENSES_Y)
        others = [k for k in range(len(self.views)) if k != ref]
        for k in others:
            cv2.warpAffine(self.views[k], self.moves[label][k], size, dst=self.moved,
                           flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                           borderMode=cv2.BORDER_REPLICATE)
            if k == others[0]:
                cv2.absdiff(self.moved, self.views[ref], dst=self.total)
            else:
                cv2.absdiff(self.moved, self.views[ref], dst=self.cost)
                cv2.add(self.total, self.cost, dst=self.total)
        return self.total

    def __call__(self):
        for (x, y), view in zip(self.maps, self.views):
            cv2.remap(self.frame, x, y, cv2.INTER_LINEAR, dst=view)
        costs = self.costs
        for label in range(LABELS):
            cv2.boxFilter(self.sum_of(label), cv2.CV_32F, (WINDOW, WINDOW), dst=costs[label],
                          normalize=False)
        best = np.argmin(costs[1:-1], 0) + 1
        lo, mid, hi = (np.take_along_axis(costs, (best + o)[None], 0)[0] for o in (-1, 0, 1))
        fine = best + (lo - hi) / (2 * np.maximum(lo - 2 * mid + hi, 1e-6))
        return self.slopes[0] + fine * (self.slopes[1] - self.slopes[0])


def error(slope):
    """Median distance from the truth, away from the border, in slope."""
    inner = (slice(8, -8), slice(8, -8))
    return float(np.median(np.abs(slope - truth())[inner]))


def case(library, frame, n, rounds):
    offsets = np.linspace(-6, 6, n)
    fast, small = (core.Stream(library, offsets, TOP, p) for p in (core.FAST, core.SMALL))
    rival = ByOpenCV(frame, offsets)
    times = core.least({'fast': lambda: fast(frame), 'small': lambda: small(frame),
                        'OpenCV': rival}, rounds)
    ours = fast(frame) / 65536
    if not np.array_equal(fast.slope, small(frame)):
        raise RuntimeError('the profiles differ')
    print(f"{n} views: fast {times['fast']:.2f} ms ({1e3 / times['fast']:.0f} frames/s, "
          f"{fast.bytes / 1024:.1f} KiB), small {times['small']:.2f} ms "
          f"({small.bytes / 1024:.1f} KiB), OpenCV {times['OpenCV']:.1f} ms: "
          f"{times['OpenCV'] / times['fast']:.1f} x and "
          f"{times['OpenCV'] / times['small']:.1f} x; median error {error(ours):.4f}, "
          f'OpenCV {error(rival()):.4f}')


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('library')
    parser.add_argument('--rounds', type=int, default=9)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    library, frame = core.Core(args.library), picture()
    for n in (5, 9):
        case(library, frame, n, args.rounds)


if __name__ == '__main__':
    main()
