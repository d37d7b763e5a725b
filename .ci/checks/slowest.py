# SPDX-License-Identifier: MIT
"""Name the slowest tests of JUnit logs.  usage: slowest.py FILE.xml ..."""
import os
import sys
import xml.etree.ElementTree as ElementTree

times = []
for path in sys.argv[1:]:
    if os.path.exists(path):
        for suite in ElementTree.parse(path).getroot().iter('testsuite'):
            seconds = float(suite.get('time') or 0)
            times.append((seconds, suite.get('name'), path.split('/meson-logs')[0]))
times = [t for t in sorted(times, reverse=True)[:5] if t[0] >= 1]
if times:
    print('slowest: ' + ', '.join(f'{n} {s:.1f} s ({b})' for s, n, b in times))
