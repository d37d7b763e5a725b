#!/bin/bash
# SPDX-License-Identifier: MIT
# From a frame to maps: import-centres, info, views, depth, refocus on a simulated scene.
set -eu
plenofix=$(realpath "$1")
here=$(dirname "$(realpath "$0")")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

cat >s.json <<'JSON'
{"seed": 3, "rays": 2, "frames": ["white", "dark", "scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [36, 28]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 560}]}
JSON
"$plenofix" simulate s.json -o s
size=$(od -An -tu1 -j16 -N8 s/scene.png | awk '{print $3*256+$4 "x" $7*256+$8}')
near() { # name, value, from, to
    awk -v v="$2" -v a="$3" -v b="$4" 'BEGIN {exit !(v >= a && v <= b)}' ||
        { echo "$1 is $2, want $3 .. $4"; exit 1; }
}
figure() { # key, file: the first number after "key":
    sed -n "s/^ *\"$1\": \([-0-9.e]*\),*\$/\1/p" "$2" | head -1
}

# Tables: labelled centres, the same without labels and in another order, round trip.
"$plenofix" import-centres s/centres.csv --size "$size" --bits 12 -o t.plut
tail -n +2 s/centres.csv | cut -d, -f3,4 | sort -R --random-source=s.json >xy.csv
"$plenofix" import-centres xy.csv --size "$size" --bits 12 -o xy.plut
"$plenofix" info t.plut --json --centres c.csv --c-array t.c >info.json
"$plenofix" info xy.plut --json --centres cxy.csv >/dev/null
cmp c.csv cxy.csv
"$plenofix" import-centres c.csv --size "$size" --bits 12 -o again.plut
cmp t.plut again.plut
near pitch "$(figure pitch info.json)" 17 17.4
grep -q '"nx": 36' info.json && grep -q '"missing": 0' info.json
[ "$(grep -o ',' t.c | wc -l)" -ge "$(stat -c %s t.plut)" ]
"$plenofix" info t.plut | grep -q 'square'
awk -F, 'NR == 1 {print; next} {printf "%s,%s,%.0f,%.0f\n", $1, $2, $3, $4}' s/centres.csv \
    >whole.csv
"$plenofix" import-centres whole.csv --size "$size" -o whole.plut
"$plenofix" import-centres whole.csv --size "$size" --smooth -o smooth.plut
"$plenofix" info whole.plut --json >whole.json
"$plenofix" info smooth.plut --json >smooth.json
near 'residual' "$(figure residual_rms smooth.json)" 0 "$(figure residual_rms whole.json)"

# Depth of a plane: every output, near the truth, in the range found.
depth() { "$plenofix" depth s/scene.png --bits 12 --lut t.plut "$@"; }
depth -o d.pfm --window 9 --confidence c.pfm --sigma e.pfm --flags f.png --png p.png --png16 g.png \
    --ply p.ply --optics s/optics.json --depth-mm mm.pfm --json >d.json
for f in d.pfm c.pfm e.pfm f.png p.png g.png p.ply mm.pfm; do
    [ -s "$f" ] || { echo "no $f"; exit 1; }
done
near measured "$(figure measured d.json)" 0.5 1
"$plenofix" evaluate d.pfm s/slope.pfm --border 6 --json >e.json
near "mean square error" "$(figure mse_x100 e.json)" 0 0.001
"$plenofix" evaluate mm.pfm s/depth_mm.pfm --border 6 --json >e.json
near "mm error" "$(figure median_x100 e.json)" 0 300
head -c 300 p.ply | grep -aq 'property float confidence'

# White and dark frames; white divides the vignetting out of a summed cost.
depth --method sweep --white s/white.png --dark s/dark.png -o w.pfm
"$plenofix" evaluate w.pfm s/slope.pfm --border 6 --json >e.json
near "mean square error" "$(figure mse_x100 e.json)" 0 0.01
# Without a white frame the band pass takes the vignetting out, also of the search.
for o in "" --band-pass; do
    # shellcheck disable=SC2086
    depth --preset onboard --radius 6 -o w.pfm --json $o >"b$o.json"
    "$plenofix" evaluate w.pfm s/slope.pfm --border 6 --json >"e$o.json"
done
grep -q '"band_pass": true' b--band-pass.json && grep -q '"band_pass": false' b.json
near "error that the band pass leaves" "$(figure median_x100 e--band-pass.json)" 0 \
    "$(awk -v e="$(figure median_x100 e.json)" 'BEGIN {print e * 2 / 3}')"
"$plenofix" views s/white.png --bits 12 --lut t.plut --white s/white.png --view-bits 8 -o flat \
    --radius 8 >/dev/null
"$plenofix" views s/white.png --bits 12 --lut t.plut --view-bits 8 -o dim --radius 8 >/dev/null
for v in flat dim; do # mean of an outer view over that of the centre
    PYTHONPATH=$here python3 -c '
import png, sys
a, b = (sum(png.samples(sys.argv[1] + "/view_%03d.png" % k)) for k in (1, 0))
print(a / b)' $v >$v.txt
done
near "white over white" "$(cat flat.txt)" 0.98 1.02
near "white alone" "$(cat dim.txt)" 0.3 0.97

# The same map from the frame and from its views, method by method.
same() { # views options -- depth options
    "$plenofix" views s/scene.png --bits 12 --lut t.plut -o v $1 >/dev/null
    depth -o a.pfm --flags a.png $2
    "$plenofix" depth --views-dir v -o b.pfm --flags b.png $2
    cmp a.pfm b.pfm
    cmp a.png b.png
    rm -r v
}
same "" ""
same "" "--method binocular"
same "" "--method sweep --slopes -0.2:0.2:17 --window 5"
same "--axes u" "--axes u --fuse correlation"
same "--method gradient" "--method gradient"
same "--adjacent" "--adjacent"
same "--views all" "--preset stream"
same "--views all" "--preset onboard"
same "--white s/white.png --view-bits 8" "--white s/white.png --view-bits 8 --cost sad"

# Refocus and all views; the same picture from views.
"$plenofix" views s/scene.png --bits 12 --lut t.plut -o all --views all >/dev/null
[ -s all/contact-sheet.png ]
"$plenofix" refocus s/scene.png --bits 12 --lut t.plut --slope 0.02 -o r1.png
"$plenofix" refocus --views-dir all --slope 0.02 -o r2.png
cmp r1.png r2.png

# Optics from targets: those of the simulated camera come back from three of its planes.
awk 'BEGIN {print "slope,distance_mm"; for (d = 400; d <= 600; d += 100)
    printf "%.6f,%g\n", (1000 / d - 1000 / 480) / -2.711207, d}' >targets.csv
"$plenofix" optics targets.csv -o fitted.json | grep -q '3 targets, error 0.0'
near inv0 "$(figure inv0 fitted.json)" 2.0832 2.0835
near gain "$(figure gain fitted.json)" -2.712 -2.711
depth -o d.pfm --window 9 --optics fitted.json --depth-mm mm2.pfm --slopes 0:0.2:9 >/dev/null
"$plenofix" evaluate mm2.pfm s/depth_mm.pfm --border 6 --json >e.json
near "mm error" "$(figure median_x100 e.json)" 0 300

# Views of a camera array, the convention of the HCI benchmark: disparity 1 is one pixel
# to the left for each column to the right, one pixel up for each row down.
PYTHONPATH=$here python3 - <<'PY'
import os
import png
os.makedirs("grid")
texture = lambda x, y: (x * x * 31 + y * y * 17 + x * y * 7) // 3 % 251
for r in range(3):
    for c in range(3):
        png.write("grid/in_%d_%d.png" % (r, c), 40, 32,
                  lambda x, y: texture(x + c - 1 + 50, y + r - 1 + 50))
PY
"$plenofix" depth --views-dir grid --grid 3x3 -o grid.pfm --json >g.json 2>/dev/null
near disparity "$(figure median g.json)" 0.98 1.02
echo '{"inv0": 1, "gain": 1}' >grid.json
"$plenofix" depth --views-dir grid --grid 3x3 -o grid.pfm --slopes -12:12:33 --json \
    --optics grid.json --depth-mm gridmm.pfm >g.json
near disparity "$(figure median g.json)" 0.9 1.1
python3 - <<'PY'
import math
import struct
with open("gridmm.pfm", "rb") as f:
    for _ in range(3):
        f.readline()
    mm = [v[0] for v in struct.iter_unpack("<f", f.read()) if not math.isnan(v[0])]
mm.sort()
assert 475 < mm[len(mm) // 2] < 525, mm[len(mm) // 2]
PY

# Bayer mosaics.
sed 's/"bits": 12/"bits": 12, "bayer": "grbg"/' s.json >bayer.json
"$plenofix" simulate bayer.json -o bayer
for c in grey r g b; do
    "$plenofix" depth bayer/scene.png --bits 12 --lut t.plut --bayer grbg --channel $c \
        -o "$c.pfm" >/dev/null
    "$plenofix" evaluate "$c.pfm" s/slope.pfm --border 6 --json >e.json
    near "mean square error of $c" "$(figure mse_x100 e.json)" 0 0.04
done

for c in import-centres info views depth refocus optics; do
    "$plenofix" $c --help | grep -q "usage: plenofix $c"
    "$plenofix" help $c >/dev/null
done
"$plenofix" --version | grep -q '^plenofix [0-9]'
echo ok
