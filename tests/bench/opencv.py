#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""SAD matching beside OpenCV's StereoBM and SGBM: one process, one thread, same images.

usage: opencv.py LIBPLENOFIX.so [--prefilter LIBBENCH_PREFILTER.so] [--rounds N]
                 [--json FILE] [--size WxH]

Needs numpy and cv2 (pip install opencv-python-headless); without them it says so and ends
with status 77, which Meson counts as skipped.  Candidates take turns; the figure is the
least processor time of the thread.  Not like for like: StereoBM filters its input by
x-Sobel (it cannot be switched off) and matches 6-bit data; ours matches the raw samples,
finds ties and range ends, and writes slopes of 32 bits.  "ours, x-Sobel" filters both
images the same way within its time (prefilter.c; built beside the library and found
there).  Our widths are all columns, OpenCV's W-D+1, and both are divided by what they
produce."""
import argparse
import ctypes as c
import json
import pathlib
import sys

try:
    import cv2
    import numpy as np
except ImportError as missing:
    print(f'skipped: {missing}')
    sys.exit(77)

import core

def pair(w, h, top, bits, seed=1):
    """A slanted plane of four-octave noise and its two 8 to 12-bit views."""
    rng = np.random.default_rng(seed)
    texture = np.zeros((h, w + top), np.float32)
    for k in (1, 2, 4, 8):
        n = rng.standard_normal((h // k + 2, (w + top) // k + 2)).astype(np.float32)
        texture += k * cv2.resize(n, (w + top, h), interpolation=cv2.INTER_CUBIC)
    texture = (texture - texture.min()) / (texture.max() - texture.min())
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    truth = 2 + (top - 5) * x / w
    left = cv2.remap(texture, x - truth, y, cv2.INTER_CUBIC,
                     borderMode=cv2.BORDER_REPLICATE)
    full = 2**bits - 1
    noisy = [np.clip(a * 0.85 * full + 0.06 * full + rng.standard_normal(a.shape), 0, full)
             for a in (left, texture[:, :w])]
    return [np.round(a).astype(np.uint16) for a in noisy] + [truth]


def disparity(ours):
    return ours.slopes() * 16


def wrong(found, truth):
    return float(np.mean(np.abs(found - truth)[~np.isnan(found)] > 1))


class Filtered:
    """Our matcher behind our x-Sobel of both images, clipped to 31 as StereoBM's."""

    def __init__(self, filters, ours, images):
        self.filters, self.ours, self.images = filters, ours, images

    def __call__(self):
        row = self.ours.block.strides[0] // 2
        for k, image in enumerate(self.images):
            h, w = image.shape
            self.filters.bench_xsobel(c.c_void_p(image.ctypes.data), w, h,
                                      c.c_void_p(self.ours.block[:, k].ctypes.data), row)
        self.ours()


def stereo_bm(labels, window, left, right):
    bm = cv2.StereoBM_create(labels, window)
    bm.setTextureThreshold(0)
    bm.setUniquenessRatio(0)
    return lambda: bm.compute(left, right)


def sgbm(labels, left, right):
    rival = cv2.StereoSGBM_create(0, labels, 9, P1=200, P2=800)
    return lambda: rival.compute(left, right)


def case(lib, filters, labels, rounds, size):
    w, h = size
    left, right, truth = pair(w, h, labels, 8)
    deep = pair(w, h, labels, 12)[:2]
    eight = [a.astype(np.uint8) for a in (left, right)]
    runs = {}
    for window in (5, 9, 21):
        runs[f'ours w{window}'] = core.matcher(lib, left, right, labels, window, 8, False)
        runs[f'StereoBM w{window}'] = stereo_bm(labels, window, *eight)
    runs['ours w9 12 bit'] = core.matcher(lib, *deep, labels, 9, 12, False)
    if filters:
        plain = core.matcher(lib, left, right, labels, 9, 8, False)
        runs['ours w9 x-Sobel'] = Filtered(filters, plain, eight)
    runs['SGBM w9'] = sgbm(labels, *eight)
    times = core.least(runs, rounds)
    ns = {}
    for name, ms in times.items():
        columns = w if name.startswith('ours') else w - labels + 1
        ns[name] = 1e6 * ms / (columns * h * labels)
    worst = max(wrong(disparity(runs[f'ours w{n}']), truth) for n in (5, 9, 21))
    return {'size': size, 'labels': labels, 'ns': ns, 'wrong': worst,
            'window 21 / 5': times['ours w21'] / times['ours w5'],
            '12 / 8 bit': times['ours w9 12 bit'] / times['ours w9']}


def show(k):
    ns = k['ns']
    size = 'x'.join(map(str, k['size']))
    print(f"{k['labels']} labels, {size}, 8 bit; ns a pixel and disparity; wrong by over 1 "
          f"column: {k['wrong']:.4f}")
    for w in (5, 9, 21):
        ours, bm = ns[f'ours w{w}'], ns[f'StereoBM w{w}']
        print(f'  window {w:2}: ours {ours:.3f}, StereoBM {bm:.3f}: {bm / ours:.2f} x')
    for name in ('ours w9 x-Sobel', 'ours w9 12 bit'):
        if name in ns:
            print(f"  {name}: {ns[name]:.3f}: {ns['StereoBM w9'] / ns[name]:.2f} x")
    print(f"  SGBM w9 {ns['SGBM w9']:.3f}: {ns['SGBM w9'] / ns['ours w9']:.2f} x")
    print(f"  window 21 costs {k['window 21 / 5']:.3f} of window 5, 12 bit "
          f"{k['12 / 8 bit']:.3f} of 8 bit")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('library')
    parser.add_argument('--prefilter')
    parser.add_argument('--rounds', type=int, default=7)
    parser.add_argument('--json')
    parser.add_argument('--size', default='640x480')
    args = parser.parse_args()
    lib = core.Core(args.library).lib
    beside = (pathlib.Path(args.library).resolve().parent.parent / 'tests' /
              'libbench_prefilter.so')
    prefilter = args.prefilter or (str(beside) if beside.exists() else None)
    filters = c.CDLL(prefilter) if prefilter else None
    cv2.setNumThreads(1)
    print(f'OpenCV {cv2.__version__}' + ('' if filters else '; no x-Sobel of ours: '
                                         'libbench_prefilter is not built'))
    size = [int(n) for n in args.size.split('x')]
    cases = [case(lib, filters, labels, args.rounds, size) for labels in (16, 32, 64)]
    for k in cases:
        show(k)
    if args.json:
        with open(args.json, 'w', encoding='utf-8') as out:
            json.dump({'opencv': cv2.__version__, 'cases': cases}, out, indent=1)


if __name__ == '__main__':
    main()
