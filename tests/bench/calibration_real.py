#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Calibration of real frames, and of others' frames with known centres.

usage: calibration_real.py PLENOFIX DATA

Prints what is measured against what is asked; exit 1 when a figure is missed, 77 when
numpy, scipy or the data is missing."""
import json
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
    from scipy.spatial import cKDTree
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

plenofix, data = os.path.realpath(sys.argv[1]), sys.argv[2]
if not os.path.isdir(os.path.join(data, "white_gt_plenopticam")):
    print(f"skipped: no {data}")
    sys.exit(77)
missed = 0


def calibrate(*names, options=()):
    """Figures, and the centres of lenses with light: x, y, flags."""
    paths = [os.path.join(data, n) for n in names]
    with tempfile.TemporaryDirectory() as d:
        table, csv = os.path.join(d, "t.plut"), os.path.join(d, "c.csv")
        out = subprocess.run([plenofix, "calibrate", *paths, *options, "-o", table,
                              "--json"], check=True, stdout=subprocess.PIPE).stdout
        subprocess.run([plenofix, "info", table, "--centres", csv], check=True,
                       stdout=subprocess.DEVNULL)
        return json.loads(out), np.loadtxt(csv, delimiter=",", skiprows=1)[:, 2:5]


def tell(what, value, limit):
    global missed
    bad = not value <= limit
    missed += bad
    print(f"{what:58} {value:10.5f}  at most {limit:g}{'  MISSED' if bad else ''}")


def nearest(found, true, reach):
    """Differences found - true of pairs within reach after the median offset."""
    good = found[(found[:, 2].astype(int) & 12) == 0][:, :2]
    _, k = cKDTree(true).query(good)
    e = good - true[k]
    return e[np.hypot(*(e - np.median(e, 0)).T) < reach]


for name, pitch in (("b", 65.4), ("c", 13.0)):
    figures, found = calibrate(f"white_gt_plenopticam/{name}.png")
    true = np.loadtxt(os.path.join(data, f"white_gt_plenopticam/{name}.txt"))[:, ::-1]
    e = nearest(found, true, pitch / 3)
    e = e - e.mean(0)
    tell(f"PlenoptiCam white {name}: mean distance after one offset",
         float(np.hypot(*e.T).mean()), 0.03)
    tell(f"PlenoptiCam white {name}: rms, 2-D", float(np.sqrt((e ** 2).sum(1).mean())), 0.03)

bench = "raw_bench_letters_plenoptomos/letters_ULF_M1"
white, centres = calibrate(bench + "_white.png")
for axis in "ab":
    step = float(np.hypot(*white["lattice"][axis]))
    tell(f"bench white: |{axis}| {step:.4f} against 48.235", abs(step - 48.235), 0.01)
tell("bench white: residual rms an axis", white["lenses"]["residual_rms"], 0.06)
scene, scene_centres = calibrate(bench + ".png")
e = nearest(scene_centres, centres[:, :2], 5.0)
for axis in (0, 1):
    tell(f"bench scene alone against its white: rms {'xy'[axis]}",
         float(np.sqrt((e[:, axis] ** 2).mean())), 0.3)

figures, _ = calibrate("raw_lfm_guv/simul_radiometry.png")
tell("simulated vesicle, white: pitch off 16", abs(figures["lattice"]["pitch"] - 16), 1e-3)
for axis in (0, 1):
    tell(f"simulated vesicle, white: origin {'xy'[axis]} off 7.5",
         abs(figures["lattice"]["origin"][axis] - 7.5), 0.01)
figures, _ = calibrate("raw_lfm_guv/exper_radiometry.png")
tell("vesicle, white: residual rms (centroid 0.037)", figures["lenses"]["residual_rms"], 0.037)
figures, _ = calibrate("raw_lfm_seaurchin/radiometry_frame.png")
tell("sea urchin, white: residual rms (centroid 0.19)",
     figures["lenses"]["residual_rms"], 0.19)

lytro = "raw_lytro_f01_tao"
figures, found = calibrate(*(f"{lytro}/IMG_{k}.png" for k in (1, 2, 3)))
table = np.fromfile(os.path.join(data, lytro, "lens_centres_362x311x2_u16le.bin"), "<u2")
e = nearest(found, table.reshape(-1, 2)[:, ::-1].astype(float), 3.0)
print(f"Lytro F01 scenes alone: offset from the camera's table {e.mean(0).round(3)}")
for axis in (0, 1):
    tell(f"Lytro F01 scenes alone against it: rms {'xy'[axis]}", float(e[:, axis].std()), 0.33)
print(f"{missed} missed")
sys.exit(missed != 0)
