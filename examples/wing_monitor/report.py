# SPDX-License-Identifier: MIT
"""Scenes, on-board input and the report of wing_monitor; standard library alone.
usage: report.py scene WING.json STILL.json
       report.py flight WING.json REGIONS.csv FRAMES FLIGHT.json
       report.py onboard RESOLVED.json REGIONS.csv FLIGHT.plxr REGIONS.bin FLIGHT.raw N
       report.py report FOLDER"""
import base64
import csv
import html
import json
import math
import pathlib
import re
import struct
import sys

REST = 8
# Of normal noise a share of 0.0027 lies over 3 standard errors and 7e-6 over 4.5: numbers
# over 3 that no flag marks are expected, over 4.5 none is.
SPOILT, CHANCE, SURE = 3.0, 0.0027, 4.5
MANY = 5000  # numbers that tell a share of 1 % from chance
MM_SLOPE, MM_LENS = -684.12, 1.125


def table(path):
    return list(csv.DictReader(open(path)))


def scene(wing, out):
    s = json.load(open(wing))
    del s['motion']
    s['frames'] = ['dots', 'scene']
    json.dump(s, open(out, 'w'))


def flight(wing, regions, frames, out):
    s = json.load(open(wing))
    s['frames'] = []
    s['motion'].update(frames=int(frames), rest=REST, blur_steps=1,
                       stations=[[int(r['j']), int(r['i'])] for r in table(regions)])
    json.dump(s, open(out, 'w'))


def onboard(resolved, regions, recording, out, raw, count):
    w, h = json.load(open(resolved))['sensor']
    rows = table(regions)
    with open(out, 'wb') as f:
        f.write(struct.pack('<5h', w, h, 12, REST, len(rows)))
        for r in rows:
            f.write(struct.pack('<5h', *(int(r[k]) for k in
                                         ('i', 'j', 'hx', 'hy', 'reference'))))
    size = 2 * w * h
    folder = pathlib.Path(recording).parent
    with open(recording, 'rb') as f, open(raw, 'wb') as g:
        stride = (size + 64 + 511) // 512 * 512
        total = pathlib.Path(recording).stat().st_size
        for n in range(min(int(count), (total - 4096) // stride)):
            f.seek(4096 + n * stride + 64)
            g.write(f.read(size))


def rms(v):
    return math.sqrt(sum(x * x for x in v) / len(v)) if v else float('nan')


def slope_through(x, y):
    mx, my = sum(x) / len(x), sum(y) / len(y)
    return (sum((a - mx) * (b - my) for a, b in zip(x, y)) /
            sum((a - mx) ** 2 for a in x))


def mac(a, b):
    ab = sum(x * y for x, y in zip(a, b))
    return ab * ab / (sum(x * x for x in a) * sum(y * y for y in b))


class Report:
    def __init__(self):
        self.rows = []

    def judge(self, what, value, limit, good, unit=''):
        number = str(value) if isinstance(value, int) else f'{value:.4g}'
        self.rows.append((what, number + unit, limit, 'PASS' if good else 'FAIL'))

    def skip(self, what, why):
        self.rows.append((what, '', why, 'skipped'))


def plot(title, lines, unit):
    """SVG of (label, colour, x, y) lines."""
    xs = [x for _, _, a, _ in lines for x in a]
    ys = [y for _, _, _, b in lines for y in b]
    x0, x1, y0, y1 = min(xs), max(xs), min(ys), max(ys)
    px = lambda x: 60 + 800 * (x - x0) / (x1 - x0)
    py = lambda y: 200 - 180 * (y - y0) / (y1 - y0)
    parts = [f'<svg viewBox="0 0 880 240"><text x="60" y="14">{html.escape(title)}</text>']
    for k in range(5):
        y = y0 + (y1 - y0) * k / 4
        parts.append(f'<text x="2" y="{py(y):.0f}">{y:.3g} {unit}</text>'
                     f'<path d="M60 {py(y):.1f}h800" stroke="#ddd"/>')
    for k in range(5):
        x = x0 + (x1 - x0) * k / 4
        parts.append(f'<text x="{px(x):.0f}" y="216" text-anchor="'
                     f'{"end" if k == 4 else "start"}">{x:.3g} s</text>')
    for n, (label, colour, a, b) in enumerate(lines):
        at = ' '.join(f'{px(x):.1f},{py(y):.1f}' for x, y in zip(a, b))
        parts.append(f'<polyline points="{at}" fill="none" stroke="{colour}"/>'
                     f'<text x="{60 + 200 * n}" y="234" fill="{colour}">{label}</text>')
    return ''.join(parts) + '</svg>'


def series_of(rows, n, column, scale=1.0):
    out = [[] for _ in range(n)]
    for r in rows:
        v = r[column]
        out[int(r['region'])].append(float(v) * scale if v else float('nan'))
    return out


def check_lattice(r, d):
    truth = {(t['row'], t['col']): (float(t['x']), float(t['y']))
             for t in table(d / 'still/centres.csv')}
    e = []
    for t in table(d / 'centres.csv'):
        x, y = truth[t['row'], t['col']]
        e += [float(t['x']) - x, float(t['y']) - y]
    r.judge('calibration: lens centres against the truth, rms', rms(e), '0.02 px',
            rms(e) <= 0.02, ' px')


def check_bits(r, d):
    host = (d / 'host.bin').read_bytes()
    if (d / 'bare.bin').exists():
        same = host == (d / 'bare.bin').read_bytes()
        r.judge('packets of this machine and of the Cortex-M7, bytes that are equal',
                len(host) if same else 0, f'{len(host)}', same)
    else:
        r.skip('packets of the Cortex-M7', 'no cross compiler or emulator')
    # The ground's own core over PNG frames saw the same.
    wide = {(round(float(g['time_s']), 6), g['region']): g for g in table(d / 'ground.csv')}
    worst = 0.0
    for s in table(d / 'series.csv'):
        g = wide.get((round(float(s['time_s']), 6), s['region']))
        if g and g['w_slope'] and s['w_mm'] and s['flags'] == '0':
            worst = max(worst, abs(float(g['w_slope']) * MM_SLOPE - float(s['w_mm'])))
    r.judge('decoded packets against the series, w', worst, '0.0014 mm (half a step)',
            worst <= 0.0014, ' mm')


def cable_over(d, times, regions):
    """[region][time]: the cable, in any view, is before the region or its margin."""
    s = json.load(open(d / 'flight.json'))
    cam, cable = s['camera'], next(o for o in s['objects'] if o['name'] == 'cable')
    lens = cam['pitch_mm'] * (cam['focus_mm'] / cam['F_mm'] - 1)
    scale = cam['focus_mm'] / cable['at_mm'][2] / lens
    # Its edges, one lens of blur, and how far the outermost views see around it.
    pupil = cam['F_mm'] / cam['working_f_number']
    reach = cable['size_mm'][0] / 2 * scale + 1 + pupil / 2 * (scale - 1 / lens)
    half = (cam['lenses'][0] - 1) / 2
    over = []
    for r in regions:
        wide = int(r['hx']) + 3 + reach
        at = [half + scale * (cable['at_mm'][0] + cable['swing_mm'][0] *
                              math.sin(2 * math.pi * cable['swing_hz'] * t)) for t in times]
        over.append([abs(x - int(r['i'])) < wide for x in at])
    return over


def check_flags(r, bad, caught, seen):
    """Of numbers that something spoilt, 95 % must be flagged.  Chance is not spoilt: what it
    leaves over 3 stated errors among the `seen` unflagged numbers is taken off."""
    missed = bad[SPOILT] - caught[SPOILT]
    chance = CHANCE * seen
    spoilt = caught[SPOILT] + max(missed - chance, 0)
    what = (f'off by over 3 stated errors: {bad[SPOILT]}, flagged {caught[SPOILT]}; of the '
            f'{missed} others chance explains {chance:.0f}; flagged of the rest')
    sure = f'off by over 4.5 stated errors, beyond chance: {bad[SURE]}, flagged {caught[SURE]}'
    enough = seen >= MANY
    if spoilt >= 40 and enough:
        r.judge(what, 100 * caught[SPOILT] / spoilt, '95 %', caught[SPOILT] >= 0.95 * spoilt,
                ' %')
    else:
        r.skip(what, 'too few for 95 %, or a flight too short to take off chance')
    if bad[SURE] >= 40:
        r.judge(sure, 100 * caught[SURE] / bad[SURE], '95 %', caught[SURE] >= 0.95 * bad[SURE],
                ' %')
    else:
        r.skip(sure, 'too few for 95 %')
    rare = 'valid numbers off by over 3 stated errors'
    if enough:
        r.judge(rare, 100 * missed / seen, f'1 % (chance: {100 * CHANCE:.2g} %)',
                missed <= 0.01 * seen, ' %')
    else:
        r.skip(rare, f'{missed} of {seen}: too few, and those of one moment go together')


def check_motion(r, d, rows, truth, regions):
    n = len(regions)
    w = series_of(rows, n, 'w_mm')
    sigma = series_of(rows, n, 'w_sigma_mm')
    flags = series_of(rows, n, 'flags')
    over = cable_over(d, [float(t['time_s']) for t in truth], regions)
    ratio, scatter, stated, a, b = [], [], [], [], []
    clear, fine, seen = 0, 0, 0
    bad, caught = {SPOILT: 0, SURE: 0}, {SPOILT: 0, SURE: 0}
    for k in range(n):
        want = [float(t[f's{k}_w_mm']) for t in truth]
        error = [x - y for x, y in zip(w[k], want)]
        good = [t for t in range(len(want)) if flags[k][t] == 0]
        for t, e in enumerate(error):
            clear += not over[k][t]
            fine += not over[k][t] and flags[k][t] == 0
            for limit in bad:
                if abs(e) > limit * sigma[k][t]:
                    bad[limit] += 1
                    caught[limit] += flags[k][t] != 0
        seen += len(good)
        if regions[k]['reference'] == '1' or len(good) < len(want) / 2:
            continue
        e = [error[t] for t in good]
        scatter.append(rms(e))
        stated.append(rms([sigma[k][t] for t in good]))
        ratio.append(stated[-1] / rms(e))
        a += [want[t] for t in good]
        b += [w[k][t] for t in good]
    scatter.sort()
    r.judge('error of w about the truth, rms, median region', scatter[len(scatter) // 2],
            '0.15 mm', scatter[len(scatter) // 2] <= 0.15, ' mm')
    stated.sort()
    r.judge('stated error of w, median region', stated[len(stated) // 2], '0.15 mm',
            stated[len(stated) // 2] <= 0.15, ' mm')
    ratio.sort()
    r.judge('stated over real error of w, median region', ratio[len(ratio) // 2],
            '0.75 to 1.25', 0.75 <= ratio[len(ratio) // 2] <= 1.25)
    r.judge('stated over real error of w, every region', ratio[0],
            '0.75 to 1.25', 0.75 <= ratio[0] and ratio[-1] <= 1.25, f' to {ratio[-1]:.3g}')
    r.judge('measurements valid where the cable is not', 100 * fine / clear, '95 %',
            fine >= 0.95 * clear, ' %')
    off = 100 * (slope_through(a, b) - 1)
    r.judge('scale of w by the lens model', off, '3 %', abs(off) <= 3, ' %')
    check_flags(r, bad, caught, seen)
    return w, flags


def check_modes(r, d, frames):
    text = (d / 'monitor.txt').read_text()
    scene = {m['hz']: m for m in json.load(open(d / 'flight.json'))['motion']['modes']}
    seconds = frames / 200
    for hz, m in sorted(scene.items()):
        found = re.search(rf'^mode {hz:g} Hz: ([\d.]+) \+- ([\d.]+) Hz, damping ([\d.-]+) '
                          r'\+- ([\d.]+) %', text, re.M)
        if not found or seconds < 5:
            r.skip(f'mode at {hz:g} Hz', f'{seconds:g} s of flight are too short')
            continue
        f, sf, z, sz = map(float, found.groups())
        bound = hz * math.sqrt(m['damping'] / (2 * math.pi * hz * seconds))
        limit = max(0.005 * hz, 3 * 1.5 * bound)
        r.judge(f'mode at {hz:g} Hz, found at', f, f'+-{limit:.3g} Hz',
                abs(f - hz) <= limit, f' +- {sf:.2g} Hz')
        lo = 100 * min(m['damping'], m.get('damping_end', 1))
        hi = 100 * m['damping']
        r.judge(f'its damping ({hi:g} %{" falling to %g %%" % lo if lo < hi else ""})', z,
                'within 3 stated errors', lo - 3 * sz <= z <= hi + 3 * sz,
                f' +- {sz:.2g} %')


def check_link(r, d, frames):
    bits = 8 * (d / 'thin.bin').stat().st_size / (frames / 200)
    r.judge('thin link', bits / 1000, '57.6 kbit/s', bits <= 57600, ' kbit/s')


def check_oma(r, d, truth):
    if not (d / 'oma.json').exists():
        r.skip('cross-check by pyOMA2', 'not installed, or flight too short')
        return
    o = json.load(open(d / 'oma.json'))
    for hz, shape, name in zip(o['hz'], o['shape'], ('bend1', 'torsion', 'bend2')):
        q = [float(t[f'{name}_mm']) for t in truth]
        others = [k for k in ('bend1', 'torsion', 'bend2') if k != name]
        want = [solve([q] + [[float(t[f'{k}_mm']) for t in truth] for k in others],
                      [float(t[f's{k}_w_mm']) for t in truth]) for k in o['regions']]
        r.judge(f'pyOMA2: {name} at {hz:.3f} Hz, MAC against the truth', mac(shape, want),
                '0.95', mac(shape, want) >= 0.95)


def solve(basis, y):
    """First coefficient of y in the basis, least squares by elimination."""
    n = len(basis)
    a = [[sum(p * q for p, q in zip(u, v)) for v in basis] +
         [sum(p * q for p, q in zip(u, y))] for u in basis]
    for i in range(n):
        for j in range(n):
            if i != j:
                f = a[j][i] / a[i][i]
                a[j] = [p - f * q for p, q in zip(a[j], a[i])]
    return a[0][n] / a[0][0]


def page(d, r, plots):
    cell = ''.join(f'<tr class="{v}"><td>{html.escape(a)}</td><td>{html.escape(b)}</td><td>'
                   f'{html.escape(c)}</td><td>{v}</td></tr>' for a, b, c, v in r.rows)
    picture = base64.b64encode((d / 'regions.png').read_bytes()).decode()
    (d / 'report.html').write_text(f'''<!doctype html><html lang="en"><meta charset="utf-8">
<title>wing_monitor</title><style>body {{ font: 15px sans-serif; max-width: 60em; margin: 2em
auto }} svg {{ width: 100%; font-size: 11px }} img {{ width: 100% }} td {{ padding: 2px 1em 2px
0; border-bottom: 1px solid #ddd }} pre {{ white-space: pre-wrap }}
.PASS td:last-child {{ color: #070 }} .FAIL
td:last-child {{ color: #b00; font-weight: bold }} .skipped {{ color: #777 }}</style>
<h1>A vibrating wing, measured by one plenoptic camera</h1>
<p>Simulated frames; the truth comes from the simulator alone. w: displacement towards the
camera. Blue regions stand on rigid structure.</p>
<img src="data:image/png;base64,{picture}" alt="regions over the raw frame">
<h2>Against the truth</h2><table><tr><th>what</th><th>measured</th><th>limit</th><th></th></tr>
{cell}</table>{''.join(plots)}<h2>Log</h2><pre>{html.escape((d / 'calibration.txt').read_text())}
{html.escape((d / 'monitor.txt').read_text())}</pre></html>
''')


def report(folder):
    d = pathlib.Path(folder)
    r = Report()
    rows = table(d / 'series.csv')
    regions = table(d / 'regions.csv')
    truth = table(d / 'flight/motion.csv')[REST:]
    check_lattice(r, d)
    check_bits(r, d)
    w, flags = check_motion(r, d, rows, truth, regions)
    check_modes(r, d, len(truth))
    check_link(r, d, len(truth))
    check_oma(r, d, truth)
    plots = []
    wing = [k for k in range(len(regions)) if regions[k]['reference'] == '0']
    for k in (wing[-1], wing[len(wing) // 2]):
        t = [float(x['time_s']) for x in truth][:800]
        good = [n for n in range(len(t)) if flags[k][n] == 0]
        plots.append(plot(f'w of region {k}', [
            ('truth', '#080', t, [float(x[f's{k}_w_mm']) for x in truth][:800]),
            ('measured', '#00c', [t[n] for n in good], [w[k][n] for n in good])], 'mm'))
    page(d, r, plots)
    for what, value, limit, verdict in r.rows:
        print(f'{verdict:8}{what}: {value} ({limit})')
    sys.exit(any(v == 'FAIL' for *_, v in r.rows))


globals()[sys.argv[1]](*sys.argv[2:])
