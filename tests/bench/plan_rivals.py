#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`plenofix plan` beside PyPI's plenoptisign: distance of the plane in focus, and
millimetres a unit of slope, for three cameras.  usage: plan_rivals.py PLENOFIX
Exit status 1 when one differs by over 1 %, 77 without the package.

Slope is the shift in lenses a pixel of aperture, so that two views G pixels apart see
slope*G lenses of disparity.  plenoptisign counts object distances from the sensor on;
with a thin lens the exit pupil lies the image distance before the array."""
import json
import subprocess
import sys

try:
    from plenoptisign import MainClass
except ImportError as error:
    print(f'skipped: {error} (pip install plenoptisign)')
    sys.exit(77)

GAP = 12  # pixels between the views


def distance(f, focus, lens_f, pitch, pixel, slope):
    image = 1 / (1 / f - 1 / focus)
    camera = MainClass({'pp': pixel, 'fs': lens_f, 'hh': 0, 'pm': pitch, 'dA': image,
                        'fU': f, 'HH': 0, 'df': focus + image, 'M': pitch / pixel,
                        'G': GAP, 'dx': slope * GAP})
    camera.tria()
    return camera.Z


bad = False
for f, focus, lens_f, pitch, pixel in ((50, 500, 0.5, 0.125, 0.0074),
                                       (50, 1000, 0.5, 0.125, 0.0074),
                                       (85, 800, 0.308, 0.077, 0.0055)):
    run = subprocess.run([sys.argv[1], 'plan', '--focal', str(f), '--focus', str(focus),
                          '--lenses', '96x20', '--lens-focal', str(lens_f), '--lens-pitch',
                          str(pitch), '--pixel', str(pixel), '--json', '--quiet'],
                         capture_output=True, text=True)
    if run.returncode:
        sys.exit(run.stderr)
    ours = json.loads(run.stdout)['mm_per_slope']
    step = 1e-4
    z = [distance(f, focus, lens_f, pitch, pixel, s) for s in (-step, 0, step)]
    theirs = (z[2] - z[0]) / (2 * step)
    off = 100 * (abs(ours / theirs) - 1)
    bad |= not abs(off) <= 1 or not abs(z[1] / focus - 1) <= 0.01
    print(f'F {f} mm, {focus} mm: in focus {z[1]:.2f} mm; {ours:.2f} mm a slope, '
          f'plenoptisign {theirs:.2f}: {off:+.3f} %')
sys.exit(bad)
