#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Sub-pixel precision on a real plane: the residual of the measured slopes about their best
plane, over the squares' edges of ../shared/data/lytro_checker_plane_7x7.

usage: checker_plane.py PLENOFIX [DATA]
Edges: windows of 9 x 9 pixels of the centre view whose mean gradient is over 2 % of full scale
(squares are flat: a window inside one measures noise); along x alone where all pairs of views
lie along x.  Prints the rms of all edges, and of the
corners, whose gradient is over 2 % along both axes, in pixels per view step."""
import os
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

WINDOW = 9
LEAST = 0.02


def read_pfm(path):
    with open(path, "rb") as f:
        f.readline()
        w, h = map(int, f.readline().split())
        f.readline()
        return np.frombuffer(f.read(), "<f4").reshape(h, w)[::-1].astype(float)


def box(a):
    pad = np.pad(a, WINDOW // 2, mode="edge").cumsum(0).cumsum(1)
    pad = np.pad(pad, ((1, 0), (1, 0)))
    n = WINDOW
    return (pad[n:, n:] - pad[:-n, n:] - pad[n:, :-n] + pad[:-n, :-n]) / n**2


def plane_rms(d, mask):
    y, x = np.nonzero(mask)
    a = np.stack([np.ones(x.size), x, y], 1)
    c = np.linalg.lstsq(a, d[mask], rcond=None)[0]
    r = d[mask] - a @ c
    return r, c


def main():
    plenofix = sys.argv[1]
    here = os.path.dirname(os.path.abspath(__file__))
    data = sys.argv[2] if len(sys.argv) > 2 else os.path.join(
        here, "../../../shared/data/lytro_checker_plane_7x7")
    if not os.path.isdir(data):
        print("skipped: no", data)
        return 77
    grey = np.asarray(Image.open(os.path.join(data, "view_4_4.png")).convert("L")) / 255.0
    gx = box(np.abs(np.diff(grey, axis=1, prepend=grey[:, :1])))
    gy = box(np.abs(np.diff(grey, axis=0, prepend=grey[:1])))
    with tempfile.TemporaryDirectory() as tmp:
        for method in ("--method plenoptic", "--method plenoptic --slopes 0.2:0.7:26",
                       "--method plenoptic --slopes 0.2:0.7:26 --fuse correlation",
                       "--method plenoptic --axes u", "--method binocular",
                       "--preset onboard"):
            out = os.path.join(tmp, "d.pfm")
            subprocess.run([plenofix, "depth", "--views-dir", data, "--grid", "7x7", "-o", out,
                            *([] if "preset" in method else ["--window", str(WINDOW)]),
                            *method.split()],
                           check=True, stdout=subprocess.DEVNULL)
            d = read_pfm(out)
            both = "--axes u" not in method and "binocular" not in method
            edge = np.isfinite(d) & ((gx + gy if both else gx) > LEAST)
            corner = edge & (gx > LEAST) & (gy > LEAST)
            r, c = plane_rms(d, edge)
            rc, _ = plane_rms(d, corner)
            print("%-58s edges %6d px, rms %.4f, 1.48 MAD %.4f; corners %6d px, rms %.4f; "
                  "slope at the middle %.3f" % (
                      method, edge.sum(), np.sqrt((r**2).mean()),
                      1.48 * np.median(np.abs(r - np.median(r))), corner.sum(),
                      np.sqrt((rc**2).mean()), c[0] + c[1] * d.shape[1] / 2
                      + c[2] * d.shape[0] / 2))
    return 0


sys.exit(main())
