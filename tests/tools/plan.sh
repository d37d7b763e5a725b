#!/bin/bash
# SPDX-License-Identifier: MIT
# plenofix plan: formulas, the library's own sizes, refusals.
set -eu
plenofix=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

plan() { "$plenofix" plan "$@"; }
ref=(--focal 50 --focus 500 --lenses 96x20 --f-number 4.1 --radius 6)

plan "${ref[@]}" --json >ref.json
plan "${ref[@]}" --region 9x9 --regions 12 --texture 0.3 --json >large.json
# The same field from four times as far: nothing of the noise changes.
plan --focal 200 --focus 2000 --lenses 96x20 --f-number 4.1 --radius 6 --json >far.json
# 16 Mpixel, field of half a metre, three quarters of the pupil.
plan --focal 40 --focus 593.67 --lenses 289x193 --radius 6.335 --json >wide.json
plan --focal 50 --focus 500 --lenses 96x20 --views 5 --radius 6 --json >five.json
python3 - <<'PY'
import json
import sys
load = lambda n: json.load(open(n + '.json'))
near = lambda a, b, e: abs(a - b) <= e * abs(b) or sys.exit(f'{a}, want {b}')
r, big, far, wide, five = map(load, ('ref', 'large', 'far', 'wide', 'five'))
L = 1 / (1 / 50 - 1 / 500)
near(r['array_mm'], L, 1e-7)
near(r['field_w_mm'], 96 * 0.125 * 500 / L, 1e-7)
near(r['pitch_px'], 0.125 * (1 + 0.5 / L) / 0.0074, 1e-7)
# Depth against slope: the derivative of 1/d = inv0 + gain*D.
gain = -1000 / (L * L * 0.0074 / (0.5 * 0.125))
near(r['mm_per_slope'], 0.5 ** 2 * gain * 1000, 1e-7)
# The reference set-up as it was simulated: 0.12 mm out of plane, 0.0007 lens in it.
near(r['sigma_w_mm'], 0.12, 0.05)
near(r['sigma_u_lens'], 0.0007, 0.05)
for p, field in ((r, 108.0), (wide, 500.0)):
    n = 4.1 if p is r else 4
    sensor = p['lenses'][0] * 0.125
    near(p['field_w_mm'], field, 1e-3)
    near(p['sigma_w_mm'], 0.125 * n / p['pupil_used'] * (p['field_w_mm'] / sensor) ** 2
         * p['sigma_delta_lens'], 1e-7)
    near(p['sigma_u_mm'], 0.125 * p['field_w_mm'] / sensor * p['sigma_u_lens'], 1e-7)
near(wide['sigma_w_mm'] / wide['sigma_delta_lens'] * 0.005, 0.64, 0.01)
near(far['sigma_w_mm'], r['sigma_w_mm'], 0.02)
near(far['field_w_mm'], r['field_w_mm'], 1e-7)
near(big['sigma_u_lens'], r['sigma_u_lens'] * (63 / 81) ** 0.5 * 0.9, 1e-7)
# Five views share no pixel: the bound for independent samples.
s2 = 4 / 9 * (12000 + 16 ** 2) / 12000 ** 2
near(five['sigma_u_lens'], (s2 / (63 * 5)) ** 0.5 / 0.27, 1e-7)
near(five['sigma_slope'], (s2 / (63 * 4 * 36)) ** 0.5 / 0.27, 1e-7)
near(r['multiply_adds_frame'], 24 * (63 * 25 * 6 + 9 * 25 * 5 + 1450 + 6), 1e-7)
near(r['raw_bit_s'], r['sensor_px'][0] * r['sensor_px'][1] * 12 * 200, 1e-7)
near(r['records_bit_s'], (26 + 24 * 8) * 8 * 200 + (22 + 40 + 22 + 96) * 8, 1e-7)
r['link_used_bit_s'] <= 57600 or sys.exit('over the link')
PY
plan "${ref[@]}" | grep -q '^field *108 x 22.5 mm'

# Memory is what monitor takes.
cat >s.json <<'JSON'
{"seed": 3, "rays": 1, "frames": ["scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [30, 20]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 500}]}
JSON
"$plenofix" simulate s.json -o a
size=$(od -An -tu1 -j16 -N8 a/scene.png | awk '{print $3*256+$4 "x" $7*256+$8}')
"$plenofix" import-centres a/centres.csv --size "$size" --bits 12 -o t.plut >/dev/null
printf 'i,j,hx,hy\n8,9,3,4\n20,9,3,4\n' >r.csv
mkdir f
for n in 0 1 2; do cp a/scene.png f/f_$n.png; done
"$plenofix" monitor f --lut t.plut --regions r.csv --bits 12 --rest 2 -o o.csv >log
want=$(sed -n 's/.*workspace \([0-9]*\) bytes.*/\1/p' log)
plan --optics a/optics.json --lenses 30x20 --regions 2 --json |
    grep -q "\"workspace_bytes\": $want,"
# An option outdoes the file.
plan --optics a/optics.json --focus 960 --lenses 30x20 --regions 2 | grep -q 'at 960 mm'

bad() { # exit status wanted, words wanted, options
    local want=$1 words=$2 got=0
    shift 2
    plan "$@" >out 2>err || got=$?
    [ $got = "$want" ] && [ "$(wc -l <err)" = 1 ] && grep -q -- "$words" err &&
        [ ! -s out ] || { echo "$*: exit $got, $(cat err); want $want, $words"; exit 1; }
}
bad 2 'want --optics' --lenses 9x9
bad 2 'want --lenses' --focal 50 --focus 500
bad 2 'COLUMNSxROWS' --focal 50 --focus 500 --lenses 96
bad 2 'COLUMNSxROWS' --focal 50 --focus 500 --lenses 96x0
bad 2 'beyond the focal length' --focal 50 --focus 40 --lenses 96x20
bad 2 'pixels wide' "${ref[@]}" --pixel 0.1
bad 2 'f-number near' "${ref[@]}" --f-number 22
bad 2 'f-number near' "${ref[@]}" --f-number 1
bad 2 'radius of a micro-image' "${ref[@]}" --radius 12
bad 2 'over 32767' --focal 50 --focus 500 --lenses 4000x20
bad 2 'margin of 3' "${ref[@]}" --region 7x17
bad 2 'odd sides' "${ref[@]}" --region 8x9
bad 2 'overlap' "${ref[@]}" --regions 40
bad 2 'want 5, 9' "${ref[@]}" --views 24
bad 2 'not one region' "${ref[@]}" --link 100
bad 2 'from 1 to 8000' "${ref[@]}" --rate 1e9
bad 2 'from 1 to 5000' "${ref[@]}" --focal nan
bad 1 'F_mm" is missing' --optics s.json --lenses 9x9
echo '{"F_mm": 50}' >o.json
bad 1 'focus_mm" is missing' --optics o.json --lenses 9x9
bad 1 'absent' --optics absent.json --lenses 9x9
plan "${ref[@]}" --f-number 3.5 2>&1 >/dev/null | grep -q 'warning: micro-images overlap'
echo "plan works"
