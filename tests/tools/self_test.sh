#!/bin/bash
# SPDX-License-Identifier: MIT
# plenofix self-test: noise floor of a still target, scale from steps, what fails.
set -eu
plenofix=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

film() { # name, frames, keys of the target: a sequence and its table
    cat >$1.json <<JSON
{"seed": 8, "rays": 1, "frames": [],
 "camera": {"F_mm": 50, "focus_mm": 500, "working_f_number": 4.1, "f_mu_mm": 0.5,
            "pitch_mm": 0.125, "pixel_mm": 0.0074, "lenses": [34, 17]},
 "sensor": {"bits": 12, "full_well_e": 30000, "read_noise_e": 16, "offset": 64},
 "motion": {"rest": 8, "frames": $2, "rate_hz": 100},
 "objects": [{"type": "rect", "at_mm": [0, 0, 500], "size_mm": [80, 60]$3,
    "texture": {"pattern": "speckle", "mean": 0.5, "contrast": 0.3, "cell_mm": 5, "soft_mm": 0.5}}]}
JSON
    "$plenofix" simulate $1.json -o $1
}
film still 40 ''
size=$(od -An -tu1 -j16 -N8 still/frame_00000.png | awk '{print $3*256+$4 "x" $7*256+$8}')
"$plenofix" import-centres still/centres.csv --size "$size" --bits 12 -o t.plut >log
printf 'i,j,hx,hy\n8,8,3,4\n16,8,3,4\n25,8,3,4\n' >r.csv
self_test() { "$plenofix" self-test "$@" --lut t.plut --regions r.csv --bits 12; }

# A target at rest: what is stated is what is seen.
self_test noise still -o n.csv >log
grep -q '^noise: PASS$' log
grep -q '^40 frames, 3 regions, 0.00 % flagged' log
[ "$(wc -l <n.csv)" = 10 ]
self_test noise still/frame_*.png --json >json
grep -q '"pass": true' json
"$plenofix" record still/frame_*.png --bits 12 -o still.plxr --quiet >/dev/null
self_test noise still.plxr >again
cmp log again

# A target that creeps fails, and so does one whose light goes out.
film creep 40 ', "swing_mm": [0.02, 0, 0], "swing_hz": 0.4'
got=0
self_test noise creep >log || got=$?
[ $got = 1 ]
grep -q '^noise: FAIL: .*u drifts by' log
mkdir dim
cp still/frame_0000*.png still/frame_0001*.png still/frame_0002*.png dim
cat >dark.py <<'PY'
import struct, sys, zlib
w, h = map(int, sys.argv[1].split('x'))
chunk = lambda k, d: struct.pack('>I', len(d)) + k + d + struct.pack('>I', zlib.crc32(k + d))
for n in range(30, 45):
    open(f'dim/frame_000{n}.png', 'wb').write(
        b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', w, h, 16, 0, 0, 0, 0))
        + chunk(b'IDAT', zlib.compress((b'\0' + b'\0\x40' * w) * h)) + chunk(b'IEND', b''))
PY
python3 dark.py "$size"
got=0
self_test noise dim >log || got=$?
[ $got = 1 ]
grep -q '^noise: FAIL: 40.5 % of the measurements are flagged' log

# Steps in the plane, then towards the camera: 1.125 mm a lens, -684 mm a unit of slope.
film move 24 ', "swing_mm": [0.4, 0, 0], "swing_hz": 2.1'
film deep 30 ', "swing_mm": [0, 0, -3.5], "swing_hz": 3.4'
for n in $(seq 8 37); do
    mv deep/frame_000$(printf %02d $n).png move/frame_000$((n + 24)).png
done
python3 - <<'PY'
import math
with open('steps.csv', 'w') as f:
    f.write('frame,u_mm,w_mm\n')
    for n in range(8, 32):
        s = math.sin(2 * math.pi * 2.1 * (n - 8) / 100)
        f.write(f'{n},{0.4 * s:.9f},\n')
    for n in range(32, 62):
        s = math.sin(2 * math.pi * 3.4 * (n - 32) / 100)
        f.write(f'{n},,{3.5 * s:.9f}\n')
PY
self_test step move --steps steps.csv --mm-per-lens 1.125 --mm-per-slope -684.12 \
    -o res.csv >log
grep -q '^step: PASS$' log
[ "$(wc -l <res.csv)" = 55 ]
self_test step move --steps steps.csv --json >json
python3 - <<'PY'
import json
u, w = json.load(open('json'))['axes']
assert abs(u['mm_per_lens'] / 1.125 - 1) < 0.02, u
assert abs(w['mm_per_slope'] / -684.12 - 1) < 0.03, w
assert u['flagged'] == 0 and w['measurements'] == 90
assert u['worst_mm'] < 0.004 and w['noise_mm'] < 0.15, (u, w)
PY
sed -n 's/^for monitor: //p' log >scale
# shellcheck disable=SC2046 # options
"$plenofix" monitor move --lut t.plut --regions r.csv --bits 12 -o m.csv --quiet \
    $(cat scale) >log
head -1 m.csv | grep -q 'u_mm,v_mm,w_mm'
# Towards the camera is positive; standard errors always are.
awk -F, '$1 == 40 && ($6 < 3 || $9 <= 0) {exit 1}' m.csv
got=0
self_test step move --steps steps.csv --mm-per-lens 1.3 >log || got=$?
[ $got = 1 ]
grep -q '^step: FAIL: the scale of u is -1[0-9.]* % off' log
# Steps that did not happen.
awk -F, -v OFS=, 'NR > 12 && NR < 18 {$2 = 0.3} {print}' steps.csv >false.csv
got=0
self_test step move --steps false.csv >log || got=$?
[ $got = 1 ]
grep -q '^step: FAIL: .*off the line' log

bad() { # exit status wanted, words wanted, arguments
    local want=$1 words=$2 got=0
    shift 2
    self_test "$@" >out 2>err || got=$?
    [ $got = "$want" ] && [ "$(wc -l <err)" = 1 ] && grep -q -- "$words" err ||
        { echo "$*: exit $got, $(cat err); want $want, $words"; exit 1; }
}
bad 2 'want noise or step'
bad 2 'want noise or step' still
bad 2 'want frames' noise
bad 2 'want --steps' step move
bad 1 'want 30 of a still target' noise move/frame_0000*.png move/frame_0001*.png
printf 'frame,u_mm\n8,0\n9,0\n10,0\n11,0\n' >same.csv
bad 1 'want 3 steps at least that differ' step move --steps same.csv
printf 'frame,u_mm\n800,0\n900,1\n1000,2\n' >far.csv
bad 1 'the first frame of a step is 8' step move --steps far.csv
printf 'frame,x\n8,0\n' >other.csv
bad 1 'want columns frame' step move --steps other.csv
printf 'frame,u_mm\n8.5,0\n' >half.csv
bad 1 'row 1: want the number' step move --steps half.csv
"$plenofix" self-test noise still --lut t.plut >out 2>err && exit 1
grep -q 'want --regions' err
echo "self-test works"
