#!/bin/bash
# SPDX-License-Identifier: MIT
# plenofix select-rois: regions with texture, on one surface each, that monitor takes.
set -eu
plenofix=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

scene() { # lenses, keys of the camera, objects
    cat <<JSON
{"seed": 5, "rays": 2, "frames": ["scene"],
 "camera": {"F_mm": 50, "focus_mm": 500, "working_f_number": 4.1, "f_mu_mm": 0.5,
            "pitch_mm": 0.125, "pixel_mm": 0.0074, "lenses": [$1]$2},
 "sensor": {"bits": 12, "full_well_e": 30000, "read_noise_e": 16, "exposure": 0.9},
 "objects": [$3]}
JSON
}
speckle='"texture": {"pattern": "speckle", "mean": 0.5, "contrast": 0.35, "cell_mm": 5}'
shoot() { # name
    "$plenofix" simulate $1.json -o $1
    size=$(od -An -tu1 -j16 -N8 $1/scene.png | awk '{print $3*256+$4 "x" $7*256+$8}')
    "$plenofix" import-centres $1/centres.csv --size "$size" --bits 12 -o $1.plut >log
}
# Speckle at 500 mm behind a bar at 400 mm; the right third is bare.
scene "60, 24" "" '{"type": "rect", "at_mm": [-12, 0, 500], "size_mm": [46, 60], '"$speckle"'},
  {"type": "rect", "at_mm": [-10, 0, 400], "size_mm": [6, 60], '"$speckle"'},
  {"type": "plane", "z_mm": 500.5, "texture": {"pattern": "none", "mean": 0.5}}' >s.json
shoot s
select_rois() { "$plenofix" select-rois "$@" --bits 12; }

select_rois s/scene.png --lut s.plut -o r.csv --png r.png --regions 4 \
    --reference 0,0,15,23 >log
grep -q '^r.csv: 4 regions of 7 x 9 lenses, texture 0\.[0-9]* a lens' log
head -1 r.csv | grep -q '^i,j,hx,hy,reference,'
select_rois s/scene.png --lut s.plut -o again.csv --regions 4 --reference 0,0,15,23 \
    --json >log.json
cmp r.csv again.csv
python3 - <<'PY'
import csv
import json
import struct
import sys
rows = [{k: float(v) for k, v in r.items()} for r in csv.DictReader(open('r.csv'))]
data = open('s/slope.pfm', 'rb').read().split(b'\n', 3)
w, h = map(int, data[1].split())
v = struct.unpack(f'<{w * h}f', data[3])
truth = lambda i, j: v[(h - 1 - j) * w + i]
for n, r in enumerate(rows):
    i, j = int(r['i']), int(r['j'])
    slopes = sorted(truth(x, y) for x in range(i - 3, i + 4) for y in range(j - 4, j + 5))
    if slopes[-6] - slopes[5] > 0.03:
        sys.exit(f'region {n} at {i},{j} lies across an edge')
    around = [truth(x, y) for x in range(i - 6, i + 7) for y in range(j - 7, j + 8)]
    if sum(abs(d - slopes[31]) > 0.03 for d in around) > 6:
        sys.exit(f'the margin of region {n} at {i},{j} lies across an edge')
    if abs(slopes[31] - r['slope']) > 0.01:
        sys.exit(f'region {n}: slope {r["slope"]}, truth {slopes[31]}')
    if i + 3 > 41:
        sys.exit(f'region {n} at {i},{j} is bare')
    if r['reference'] != (i <= 15):
        sys.exit(f'region {n}: reference {r["reference"]}')
    for m in rows[:n]:
        if abs(m['i'] - i) < 7 and abs(m['j'] - j) < 9:
            sys.exit(f'region {n} overlaps')
said = json.load(open('log.json'))
assert len(said['regions']) == 4 and said['places']['flat'] > 50, said
assert said['places']['depth_edge'] > 20, said
PY

# A long wing, a strut beside it: regions at both rims and both ends, as many as wanted,
# whatever the core finds wrong near the strut.
scene "70, 20" "" '{"type": "rect", "at_mm": [0, 0, 500], "size_mm": [90, 40], '"$speckle"'},
  {"type": "rect", "at_mm": [6, 0, 420], "size_mm": [2, 60], "texture": {"pattern": "none", "mean": 0.08}}' \
    | sed 's/"cell_mm": 5/&, "soft_mm": 0.9/' >long.json
shoot long
select_rois long/scene.png --lut long.plut -o long.csv --regions 8 --region 9x7 >log
grep -q '^long.csv: 8 regions' log
awk -F, 'NR > 1 {n++; up += $2 <= 7; down += $2 >= 12; left += $1 < 20; right += $1 >= 50}
    END {exit n != 8 || up < 3 || down < 3 || left < 2 || right < 2}' long.csv ||
    { cat long.csv; exit 1; }

# The standard errors are those of plan for the texture that is told, within a quarter.
texture=$(sed -n 's/.*texture \([0-9.]*\) a lens.*/\1/p' log)
"$plenofix" plan --focal 50 --focus 500 --lenses 60x24 --regions 4 --f-number 4.1 \
    --texture "$texture" --light 0.45 --json >plan.json
python3 - <<PY
import json
regions = json.load(open('log.json'))['regions']
plan = json.load(open('plan.json'))['sigma_slope'] * float('$texture')
ratio = sorted(r['w_sigma_slope'] * r['texture'] / plan for r in regions)
assert all(0.75 < r < 1.25 for r in ratio), ratio
PY

# monitor takes the file; frames of their own tell the noise.
sed 's/"objects"/"motion": {"frames": 4}, &/; s/\["scene"\]/[]/' s.json >f.json
"$plenofix" simulate f.json -o f
"$plenofix" monitor f --lut s.plut --regions r.csv --bits 12 --rest 2 -o m.csv --quiet >log
grep -q '^2 frames, 4 regions' log
select_rois f/frame_0000?.png --lut s.plut -o q.csv --regions 4 >log
! grep -q 'full-well' log

bad() { # exit status wanted, words wanted, arguments
    local want=$1 words=$2 got=0
    shift 2
    select_rois "$@" >out 2>err || got=$?
    [ $got = "$want" ] && [ "$(wc -l <err)" = 1 ] && grep -q -- "$words" err &&
        [ ! -e x.csv ] || { echo "$*: exit $got, $(cat err); want $want, $words"; exit 1; }
}
good=(s/scene.png --lut s.plut -o x.csv)
scene "40, 24" "" '{"type": "plane", "z_mm": 500, "texture": {"pattern": "none"}}' >flat.json
shoot flat
bad 1 'no region: .*have a gradient under.*put speckle' flat/scene.png --lut flat.plut -o x.csv
bad 1 'no region: .*noisier than 1e-05' "${good[@]}" --sigma 0.00001
bad 1 'no region: 60 x 24 lenses hold none of 7 x 23' "${good[@]}" --region 7x23
sed 's/"seed": 5/"seed": 6/' s.json >other.json
"$plenofix" simulate other.json -o other
bad 1 'keep several frames still' s/scene.png other/scene.png --lut s.plut -o x.csv
scene "40, 24" ', "lattice": "hex"' '{"type": "plane", "z_mm": 500}' >hex.json
shoot hex
bad 1 'square lattice' hex/scene.png --lut hex.plut -o x.csv
bad 1 'is for' flat/scene.png --lut s.plut -o x.csv
bad 1 'is for' s/scene.png flat/scene.png --lut s.plut -o x.csv
bad 1 'absent.png' absent.png --lut s.plut -o x.csv
bad 1 'no lens table' s/scene.png --lut r.csv -o x.csv
bad 2 'want a raw frame' --lut s.plut -o x.csv
bad 2 'want --lut' s/scene.png -o x.csv
bad 2 'want -o' s/scene.png --lut s.plut
bad 2 'each odd' "${good[@]}" --region 8x9
bad 2 'I0,J0,I1,J1' "${good[@]}" --reference 1,2,3
bad 2 'want 5, 9' "${good[@]}" --views 6
bad 2 'from 1 to 64' "${good[@]}" --regions 100
bad 1 'folder does not exist' s/scene.png --lut s.plut -o none/x.csv
select_rois s/scene.png --lut s.plut -o r.csv --regions 60 2>&1 >/dev/null |
    grep -q 'warning: [0-9]* regions where 60 were wanted'
echo "select-rois works"
