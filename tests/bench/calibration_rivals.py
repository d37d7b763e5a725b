#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lens centres by plenofix calibrate beside two rivals, on frames drawn here.

usage: calibration_rivals.py PLENOFIX [lenses in a row, lenses in a column]

Rivals: PlenoptiCam 0.9.3 from PyPI (its grid fit), and a Gaussian-weighted centroid with
an affine fit that is given the true indices.  Exit 0 when ours is at least 5 times nearer
to the truth than the first and not behind the second by more than noise, 1 when not, 77
when numpy, scipy or PlenoptiCam is missing:
  python3 -m venv --system-site-packages V
  V/bin/pip install --no-deps plenopticam==0.9.3 color-space-converter color-matcher \\
    depthy "colour-demosaicing<0.2" "colour-science<0.5"
  V/bin/pip install requests typing-extensions "scikit-image<0.23" "numpy<2"
and Tk for Python (python3-tk).
"""
import contextlib
import io
import math
import os
import subprocess
import sys
import tempfile
import zlib

try:
    import numpy as np
    from scipy.spatial import cKDTree
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

PITCH, SIGMA, NOISE = 15.0, 1.6, 0.004


def draw(hexagonal, degrees, nx, ny, seed):
    """8-bit frame of Gaussian dots and the true centres [ny][nx][2]."""
    t = math.radians(degrees)
    a = PITCH * np.array([math.cos(t), math.sin(t)])
    b = PITCH * np.array([-math.sin(t), math.cos(t)]) * (math.sqrt(0.75) if hexagonal else 1)
    j, i = np.mgrid[0:ny, 0:nx]
    u = i + (0.5 * (j % 2) if hexagonal else 0.0)
    true = u[..., None] * a + j[..., None] * b
    true += np.array([20.3, 19.7]) - np.floor(true.min((0, 1)))
    w, h = (np.ceil(true.max((0, 1))) + 20).astype(int)
    im = np.full((h, w), 0.02)
    for x, y in true.reshape(-1, 2):
        x0, y0 = int(round(x)) - 10, int(round(y)) - 10
        gx = np.exp(-0.5 * ((np.arange(x0, x0 + 21) - x) / SIGMA) ** 2)
        gy = np.exp(-0.5 * ((np.arange(y0, y0 + 21) - y) / SIGMA) ** 2)
        im[y0:y0 + 21, x0:x0 + 21] += 0.8 * np.outer(gy, gx)
    im += NOISE * np.random.default_rng(seed).standard_normal(im.shape)
    return np.clip(np.rint(255 * im), 0, 255).astype(np.uint8), true


def png(path, im):
    def chunk(tag, data):
        body = tag + data
        return len(data).to_bytes(4, "big") + body + zlib.crc32(body).to_bytes(4, "big")
    h, w = im.shape
    head = w.to_bytes(4, "big") + h.to_bytes(4, "big") + bytes([8, 0, 0, 0, 0])
    rows = b"".join(b"\0" + r.tobytes() for r in im)
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head)
                + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def error(found, true):
    """rms distance of matched centres, how many of the true ones were matched, and how
    many found ones match none."""
    distance, which = cKDTree(true.reshape(-1, 2)).query(found)
    near = distance < PITCH / 3
    return (math.sqrt((distance[near] ** 2).mean()) if near.any() else math.nan,
            len(set(which[near])), int((~near).sum()))


def ours(plenofix, folder, im):
    png(os.path.join(folder, "f.png"), im)
    run = lambda *args: subprocess.run([plenofix, *args], cwd=folder, check=True,
                                       stdout=subprocess.DEVNULL)
    run("calibrate", "f.png", "-o", "f.plut")
    run("info", "f.plut", "--centres", "c.csv")
    return np.loadtxt(os.path.join(folder, "c.csv"), delimiter=",", skiprows=1)[:, 2:4]


def centroid(im, true, hexagonal):
    """Weighted centroid around every true place, then an affine fit by true indices."""
    im = im.astype(float)
    p = np.rint(true.reshape(-1, 2))
    x, y = np.meshgrid(np.arange(-6, 7), np.arange(-6, 7))
    for _ in range(6):
        q = np.rint(p).astype(int)
        px, py = q[:, 0, None, None] + x, q[:, 1, None, None] + y
        v = im[py, px]
        v = np.maximum(v - np.median(v, (1, 2))[:, None, None], 0)
        v = v * np.exp(-0.5 * ((px - p[:, :1, None]) ** 2 + (py - p[:, 1:, None]) ** 2)
                       / (2 * SIGMA) ** 2)
        p = np.stack([(v * px).sum((1, 2)), (v * py).sum((1, 2))], 1) / v.sum((1, 2))[:, None]
    ny, nx = true.shape[:2]
    j, i = np.mgrid[0:ny, 0:nx]
    u = i + (0.5 * (j % 2) if hexagonal else 0.0)
    basis = np.stack([np.ones(nx * ny), u.ravel(), j.ravel()], 1)
    return basis @ np.linalg.lstsq(basis, p, rcond=None)[0]


def plenopticam(folder, im):
    from plenopticam import cfg as config
    from plenopticam import lfp_calibrator
    cfg = config.PlenopticamConfig()
    cfg.default_values()
    cfg.params[cfg.opt_prnt] = False
    cfg.params[cfg.cal_meth] = "grid-fit"
    cfg.params[cfg.cal_path] = os.path.join(folder, "c.json")
    cfg.params[cfg.lfp_path] = os.path.join(folder, "f.png")
    calibrator = lfp_calibrator.LfpCalibrator(wht_img=im.astype(float), cfg=cfg)
    with contextlib.redirect_stdout(io.StringIO()):
        calibrator.main()
    return np.array(cfg.calibs[cfg.mic_list])[:, 1::-1]


def main():
    plenofix = os.path.realpath(sys.argv[1])
    nx, ny = (int(v) for v in sys.argv[2:4]) if len(sys.argv) > 3 else (60, 40)
    try:
        import plenopticam as _  # noqa: F401
    except ImportError as missing:
        print(f"skipped: {missing}")
        return 77
    status = 0
    log = {"ours": 0.0, "plenopticam": 0.0, "centroid": 0.0}
    print(f"{nx * ny} dots of {PITCH} px: 2-D rms px, found, invented")
    print(f"{'lattice':8}{'deg':>5}{'plenofix':>24}{'plenopticam grid-fit':>26}"
          f"{'centroid + affine':>26}")
    cases = [(h, d) for h in (False, True) for d in (0.0, 0.3, 1.0)]
    for hexagonal, degrees in cases:
        im, true = draw(hexagonal, degrees, nx, ny, int(10 * degrees) + hexagonal)
        row = {}
        with tempfile.TemporaryDirectory() as folder:
            row["ours"] = error(ours(plenofix, folder, im), true)
            try:
                row["plenopticam"] = error(plenopticam(folder, im), true)
            except Exception as failure:  # it stops with any kind on some frames
                print(f"plenopticam failed: {type(failure).__name__}: {failure}")
                row["plenopticam"] = (math.nan, 0, 0)
        row["centroid"] = error(centroid(im, true, hexagonal), true)
        print(f"{'hex' if hexagonal else 'square':8}{degrees:5.1f}" + "".join(
            f"{row[k][0]:14.5f}{row[k][1]:6}{row[k][2]:4}  "
            for k in ("ours", "plenopticam", "centroid")))
        for k in log:
            log[k] += row[k][0] ** 2 / len(cases)
        if row["ours"][1] != nx * ny or row["ours"][2] or 5 * row["ours"][0] > row["plenopticam"][0]:
            status = 1
    total = {k: math.sqrt(v) for k, v in log.items()}
    print("all " + ", ".join(f"{k} {v:.5f}" for k, v in total.items()))
    # Both fits sit at the noise of 2,400 spots; 0.0001 px is its scatter.
    return 1 if status or total["ours"] > total["centroid"] + 1e-4 else 0


sys.exit(main())
