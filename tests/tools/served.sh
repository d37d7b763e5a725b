# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# For the tests of cameras, sourced by them: PLENOFIX SERVE CAMERA.xml are the first
# arguments.  Leaves in a folder of its own a scene of 12 bits (s/), its table (t.plut) and
# its bare frame of 16 bits a pixel (f.raw), and sets plenofix, serve, xml, size, pixels.
plenofix=$(realpath "$1") serve=$(realpath "$2") xml=$(realpath "$3")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"
cat >s.json <<'JSON'
{"seed": 4, "rays": 1, "frames": ["scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [24, 18]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 560}]}
JSON
"$plenofix" simulate s.json -o s >/dev/null
size=$(od -An -tu1 -j16 -N8 s/scene.png | awk '{print $3*256+$4 "x" $7*256+$8}')
pixels=$((${size%x*} * ${size#*x}))
"$plenofix" import-centres s/centres.csv --size "$size" --bits 12 -o t.plut >/dev/null
"$plenofix" record s/scene.png --bits 12 -o f.plxr >/dev/null
tail -c +$((4096 + 64 + 1)) f.plxr | head -c $((2 * pixels)) >f.raw
