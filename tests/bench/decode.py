#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Decoding of a 16-megapixel frame, 13 x 13 views, beside cv2.remap and plenopticam.

usage: decode.py LIBPLENOFIX.so [--rounds N]

4904 x 3280 pixels of 12 bits, 289 x 193 lenses, pitch 16.93, turned by 0.05 degrees.  One
process, one thread, the same frame; the least processor time of the thread.  cv2.remap
makes each view by one call, with maps made before (float and fixed); plenopticam 0.9.3
resamples its micro-images, the first lens rows, and the figure is scaled to all: its time
a lens does not depend on the row.  Needs numpy and one of the two; without them it ends
with status 77, which Meson counts as skipped.  plenopticam wants numpy under 1.24 and
scipy under 1.12: run the script once with each Python."""
import argparse
import sys
import types

try:
    import numpy as np
except ImportError as missing:
    print(f'skipped: {missing}')
    sys.exit(77)

import core

SIDE = 13
ROWS = 4  # lens rows that plenopticam resamples


def picture():
    """A frame with texture at the scale of a few pixels."""
    rng = np.random.default_rng(1)
    frame = rng.integers(0, 4096, (core.SENSOR_H, core.SENSOR_W)).astype(np.float32)
    for axis in (0, 1):
        frame = (np.roll(frame, 1, axis) + 2 * frame + np.roll(frame, -1, axis)) / 4
    return np.round(frame).astype(np.uint16)


def offsets():
    return [(u - SIDE // 2, v - SIDE // 2) for v in range(SIDE) for u in range(SIDE)]


def exact(offset):
    """Sampling points of a view in pixels, without rounding."""
    u, v = offset
    return core.centres() + np.array([u * np.cos(core.TURN) - v * np.sin(core.TURN),
                                      u * np.sin(core.TURN) + v * np.cos(core.TURN)])


def by_double(frame, p):
    """Bilinear samples at the points p."""
    whole = np.floor(p).astype(int)
    fx, fy = (p - whole)[..., 0], (p - whole)[..., 1]
    x, y = whole[..., 0], whole[..., 1]
    f = frame.astype(np.float64)
    return ((f[y, x] * (1 - fx) + f[y, x + 1] * fx) * (1 - fy) +
            (f[y + 1, x] * (1 - fx) + f[y + 1, x + 1] * fx) * fy)


def errors(library, frame, out):
    """Largest error of a sample at its point in 1/256 pixel, and of the point, over the
    views of one diagonal."""
    worst = astray = 0
    for k in range(0, SIDE * SIDE, SIDE + 1):
        p = library.places(*offsets()[k])
        worst = max(worst, np.abs(out[:, k] - by_double(frame, p)).max())
        astray = max(astray, np.abs(p - exact(offsets()[k])).max())
    return worst, astray


def remaps(cv2, frame):
    cv2.setNumThreads(1)
    points = [exact(o).astype(np.float32) for o in offsets()]
    planes = [(np.ascontiguousarray(p[..., 0]), np.ascontiguousarray(p[..., 1]))
              for p in points]
    fixed = [cv2.convertMaps(x, y, cv2.CV_16SC2) for x, y in planes]
    out = np.empty((core.LENSES_Y, core.LENSES_X), np.uint16)

    def floats():
        for x, y in planes:
            cv2.remap(frame, x, y, cv2.INTER_LINEAR, dst=out)

    def fixeds():
        for x, y in fixed:
            cv2.remap(frame, x, y, cv2.INTER_LINEAR, dst=out)
    return {'cv2.remap, float maps': floats, 'cv2.remap, fixed maps': fixeds}


def plenopticam_rows(frame):
    """Resampling of ROWS lens rows, or None where the package is missing."""
    sys.modules.setdefault('colour_demosaicing', types.ModuleType('colour_demosaicing'))
    for name in ('bilinear', 'Malvar2004', 'Menon2007'):
        setattr(sys.modules['colour_demosaicing'], f'demosaicing_CFA_Bayer_{name}', None)
    try:
        from plenopticam.cfg import PlenopticamConfig
        from plenopticam.lfp_aligner.lfp_local_resampler import LfpLocalResampler
    except (ImportError, AttributeError) as missing:
        print(f'plenopticam: skipped: {missing}')
        return None
    centres = core.centres()
    cfg = PlenopticamConfig()
    cfg.params[cfg.ptc_leng] = SIDE
    cfg.params[cfg.opt_prnt] = False
    cfg.calibs = {cfg.pat_type: 'rec', cfg.ptc_mean: [core.PITCH, core.PITCH],
                  cfg.mic_list: [[centres[j, i, 1], centres[j, i, 0], j, i]
                                 for j in range(core.LENSES_Y) for i in range(core.LENSES_X)]}
    aligner = LfpLocalResampler(lfp_img=frame[..., None], cfg=cfg)
    aligner._LENS_Y_MAX = ROWS
    return aligner.resample_rec


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('library')
    parser.add_argument('--rounds', type=int, default=7)
    args = parser.parse_args()
    frame = picture()
    out = np.zeros((core.LENSES_Y, SIDE * SIDE, core.LENSES_X), np.uint16)
    library = core.Core(args.library)
    candidates = {'ours': library.decode(frame, offsets(), out)}
    try:
        import cv2
        candidates.update(remaps(cv2, frame))
    except ImportError as missing:
        print(f'OpenCV: skipped: {missing}')
    candidates['ours']()
    worst, astray = errors(library, frame, out)
    times = core.least(candidates, args.rounds)
    rows = plenopticam_rows(frame)
    if rows:
        once = core.least({'plenopticam': rows}, 1)['plenopticam']
        times['plenopticam, scaled'] = once * core.LENSES_Y / ROWS
    print(f"ours: {times['ours']:.2f} ms, {1e6 * times['ours'] / out.size:.2f} ns a sample, "
          f'largest error {worst:.3f} LSB, {astray:.4f} px')
    for name, ms in times.items():
        if name != 'ours':
            print(f"{name:24} {ms:10.1f} ms, ours is {ms / times['ours']:7.1f} x as fast")
    sys.exit(77 if len(times) == 1 else int(worst > 1))


if __name__ == '__main__':
    main()
