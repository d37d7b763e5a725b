#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Series that `plenofix monitor` wrote, read back by others: pyuff and h5py.
usage: motion_files.py SERIES.csv SERIES.uff SERIES.h5
Exit status 1 when a value differs by more than the CSV's digits, 77 without them."""
import csv
import sys

try:
    import h5py
    import numpy as np
    import pyuff
except ImportError as error:
    print(f'skipped: {error}')
    sys.exit(77)

path_csv, path_uff, path_h5 = sys.argv[1:]
with open(path_csv, newline='') as f:
    rows = list(csv.DictReader(f))
axes = [k for k in rows[0] if k[:2] in ('u_', 'v_', 'w_') and 'sigma' not in k]
regions = 1 + max(int(r['region']) for r in rows)
series = np.array([[float(r[k]) if r[k] and r['flags'] == '0' else np.nan for k in axes]
                   for r in rows]).reshape(-1, regions, 3)
hdf = h5py.File(path_h5)
sets = pyuff.UFF(path_uff).read_sets()
nodes = [s for s in sets if s['type'] == 15]
sets = [s for s in sets if s['type'] == 58]
uff = np.array([s['data'] for s in sets]).reshape(regions, 3, -1).transpose(2, 0, 1)
scale = np.nanmax(np.abs(series))
worst_h5 = np.nanmax(np.abs(hdf['displacement'][:] - series)) / scale
worst_uff = np.nanmax(np.abs(uff - np.nan_to_num(hdf['displacement'][:]))) / scale
same = np.array_equal(np.isnan(hdf['displacement'][:]), np.isnan(series))
if 'x_mm' in rows[0]:
    place = np.array([[float(r[k]) for k in ('x_mm', 'y_mm', 'z_mm')]
                      for r in rows[:regions]])
    seen = np.array([nodes[0][k] for k in 'xyz']).T
    same &= len(nodes) == 1 and np.allclose(seen, place, rtol=1e-5)
    same &= np.allclose(hdf['place'][:], place, rtol=1e-8)
    print(f'places of {len(seen)} nodes agree: {same}')
print(f'{len(sets)} UFF sets of {len(uff)} samples; CSV and HDF5 differ by '
      f'{worst_h5:.1e}, HDF5 and UFF by {worst_uff:.1e}; gaps agree: {same}; '
      f'units {hdf["displacement"].attrs["units"]}')
sys.exit(not (worst_h5 < 1e-6 and worst_uff < 1e-11 and same))
