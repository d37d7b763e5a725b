# SPDX-License-Identifier: MIT
"""Modes of the series by pyOMA2 (SSI), as a second opinion.
usage: oma.py SERIES.csv REGIONS.csv OUT.json   writes nothing and says why when it cannot."""
import csv
import json
import sys

series, regions, out = sys.argv[1:]
try:
    import numpy as np
    from pyoma2.algorithms import SSI
    from pyoma2.setup import SingleSetup
except ImportError as e:
    print(f'oma: skipped: {e.name} is not installed (pip install pyOMA-2)')
    sys.exit(0)
wing = [k for k, r in enumerate(csv.DictReader(open(regions))) if r['reference'] == '0']
rows = list(csv.DictReader(open(series)))
n = max(int(r['region']) for r in rows) + 1
w = np.array([float(r['w_mm']) if r['w_mm'] and r['flags'] == '0' else np.nan
              for r in rows]).reshape(-1, n)[:, wing]
if len(w) < 1000:
    print(f'oma: skipped: {len(w)} frames, want 1000')
    sys.exit(0)
keep = np.isnan(w).mean(0) == 0
w = w[:, keep] - w[:, keep].mean(0)
setup = SingleSetup(w, fs=200.0)
setup.add_algorithms(SSI(name='ssi', method='cov', br=40, ordmax=24))
setup.run_by_name('ssi')
setup.mpe('ssi', sel_freq=[6.2, 22.0, 38.9], order_in=12)
found = setup['ssi'].result
json.dump({'hz': list(map(float, found.Fn)), 'damping': list(map(float, found.Xi)),
           'regions': [k for k, u in zip(wing, keep) if u],
           'shape': np.real(found.Phi).T.tolist()}, open(out, 'w'))
