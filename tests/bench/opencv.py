#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Time of the core beside OpenCV: one process, one thread, the same images.

usage: opencv.py LIBPLENOFIX.so [--rounds N] [--json FILE]

Needs numpy and cv2 (pip install opencv-python-headless); without them it says so and ends
with status 77, which Meson counts as skipped.  Candidates take turns; the figure is the
least processor time of the thread.  Not like for like: StereoBM filters its input by
x-Sobel (it cannot be switched off) and matches 6-bit data; ours matches the raw samples,
finds ties and range ends, and writes slopes of 32 bits.  Our widths are all columns,
OpenCV's W-D+1, and both are divided by what they produce."""
import argparse
import ctypes as c
import json
import sys
import time

try:
    import numpy as np
    import cv2
except ImportError as missing:
    print(f'skipped: {missing}')
    sys.exit(77)


class Offset(c.Structure):
    _fields_ = [('u', c.c_int16), ('v', c.c_int16)]


class Cfg(c.Structure):
    _fields_ = ([(n, c.c_uint8) for n in
                 ('method', 'cost', 'fit', 'fuse', 'window', 'bits', 'ref', 'n')] +
                [(n, c.c_uint16) for n in ('labels', 'texture', 'unique')] +
                [('slope_min', c.c_int32), ('slope_max', c.c_int32), ('at', Offset * 128)])


class Views(c.Structure):
    _fields_ = [('px', c.c_void_p), ('nx', c.c_int32), ('ny', c.c_int32),
                ('n', c.c_int32)]


class Map(c.Structure):
    _fields_ = [('slope', c.c_void_p), ('conf', c.c_void_p), ('sigma', c.c_void_p),
                ('flags', c.c_void_p), ('w', c.c_int32), ('h', c.c_int32),
                ('stride', c.c_int32)]


class Matcher:
    """Two views, label l = l columns, through plfx_sweep()."""

    def __init__(self, lib, left, right, labels, window, bits, ncc):
        h, w = left.shape
        self.lib, self.w, self.h, self.labels = lib, w, h, labels
        cfg = Cfg(method=int(ncc), cost=int(ncc), window=window, bits=bits, n=2,
                  labels=labels, slope_max=(labels - 1) * 4096)
        cfg.at[1].u = -16 * 256
        self.plan = c.create_string_buffer(8192)
        if lib.plfx_plan_init(self.plan, c.byref(cfg), None, w, h) != 0:
            raise RuntimeError('plan refused')
        lib.plfx_sweep_ws.restype = c.c_size_t
        self.size = lib.plfx_sweep_ws(self.plan)
        self.raw = np.zeros(self.size + 64, np.uint8)
        self.ws = self.raw.ctypes.data + (-self.raw.ctypes.data) % 64
        self.block = np.empty((h, 2, w), np.uint16)
        self.block[:, 0], self.block[:, 1] = left, right
        self.slope = np.zeros((h, w), np.int32)
        self.views = Views(self.block.ctypes.data, w, h, 2)
        self.map = Map(self.slope.ctypes.data, None, None, None, w, h, w)

    def __call__(self):
        if self.lib.plfx_sweep(self.plan, c.byref(self.views), c.byref(self.map),
                               c.c_void_p(self.ws), c.c_size_t(self.size)) != 0:
            raise RuntimeError('sweep refused')

    def disparity(self):
        return np.where(self.slope == -2**31, np.nan, self.slope / 4096.0)


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


def box_ncc(left, right, labels, window):
    """Zero-mean NCC as one writes it with OpenCV: box filters of float32."""
    size = (window, window)
    a, b = left.astype(np.float32), right.astype(np.float32)

    def run():
        ma, mb = cv2.boxFilter(a, -1, size), cv2.boxFilter(b, -1, size)
        va = cv2.boxFilter(a * a, -1, size) - ma * ma
        vb = cv2.boxFilter(b * b, -1, size) - mb * mb
        best = np.full(a.shape, -2, np.float32)
        index = np.zeros(a.shape, np.int16)
        for d in range(labels):
            al, br = a[:, d:], b[:, :a.shape[1] - d]
            cov = cv2.boxFilter(al * br, -1, size) - ma[:, d:] * mb[:, :a.shape[1] - d]
            r = cov / np.sqrt(va[:, d:] * vb[:, :a.shape[1] - d] + 1e-6)
            better = r > best[:, d:]
            best[:, d:][better] = r[better]
            index[:, d:][better] = d
        return index
    return run


def least(candidates, rounds):
    times = {name: float('inf') for name in candidates}
    for _ in range(rounds):
        for name, run in candidates.items():
            start = time.thread_time_ns()
            run()
            times[name] = min(times[name], time.thread_time_ns() - start)
    return times


def sad_case(lib, w, h, labels, window, bits, rounds):
    left, right, truth = pair(w, h, labels, bits)
    ours = Matcher(lib, left, right, labels, window, bits, False)
    bm = cv2.StereoBM_create(labels, max(window, 5))
    bm.setTextureThreshold(0)
    bm.setUniquenessRatio(0)
    l8, r8 = [(a >> (bits - 8)).astype(np.uint8) for a in (left, right)]
    times = least({'ours': ours, 'bm': lambda: bm.compute(l8, r8)}, rounds)
    d = ours.disparity()
    wrong = float(np.mean(np.abs(d - truth)[~np.isnan(d)] > 1))
    return {'case': f'SAD {w}x{h} D{labels} w{window} {bits} bit',
            'ours_ns': times['ours'] / (w * h * labels),
            'opencv_ns': times['bm'] / ((w - labels + 1) * h * labels),
            'wrong': wrong}


def ncc_case(lib, w, h, labels, window, rounds):
    left, right, truth = pair(w, h, labels, 8)
    ours = Matcher(lib, left, right, labels, window, 8, True)
    times = least({'ours': ours, 'box': box_ncc(left, right, labels, window)}, rounds)
    d = ours.disparity()
    wrong = float(np.mean(np.abs(d - truth)[~np.isnan(d)] > 1))
    return {'case': f'NCC {w}x{h} D{labels} w{window}',
            'ours_ns': times['ours'] / (w * h * labels),
            'opencv_ns': times['box'] / (w * h * labels), 'wrong': wrong}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('library')
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--json')
    args = parser.parse_args()
    lib = c.CDLL(args.library)
    cv2.setNumThreads(1)
    cases = [sad_case(lib, 640, 480, d, w, 8, args.rounds)
             for d in (16, 32, 64) for w in (5, 9, 21)]
    cases.append(sad_case(lib, 640, 480, 16, 9, 12, args.rounds))
    cases += [ncc_case(lib, 640, 480, d, 9, max(args.rounds // 2, 1)) for d in (17, 64)]
    print(f'OpenCV {cv2.__version__}; ns per pixel and disparity')
    for k in cases:
        k['ratio'] = k['opencv_ns'] / k['ours_ns']
        print(f"{k['case']:28} ours {k['ours_ns']:7.3f}  OpenCV {k['opencv_ns']:7.3f}  "
              f"ratio {k['ratio']:5.2f}  wrong by over 1: {k['wrong']:.3f}")
    if args.json:
        with open(args.json, 'w', encoding='utf-8') as out:
            json.dump({'opencv': cv2.__version__, 'cases': cases}, out, indent=1)


if __name__ == '__main__':
    main()
