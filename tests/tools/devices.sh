#!/bin/bash
# SPDX-License-Identifier: MIT
# plenofix devices, and depth --device: the same map to the byte, or a clear refusal.
set -eu
plenofix=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"
export POCL_CACHE_DIR="$dir/pocl"
mkdir pocl

"$plenofix" devices | grep -q '^cpu '
"$plenofix" devices --help | grep -q 'depth --device'
refused() { # status, words, command ...
    local want=$1 words=$2 status=0
    shift 2
    "$@" >/dev/null 2>err || status=$?
    [ $status -eq "$want" ] && grep -q "$words" err && [ "$(wc -l <err)" -eq 1 ] ||
        { echo "$*: status $status, said: $(cat err)"; exit 1; }
}
refused 2 surplus "$plenofix" devices surplus
[ "$("$plenofix" info --devices)" = "$("$plenofix" devices)" ]
refused 2 'want CAM.plut' "$plenofix" info
refused 2 'want CAM.plut' "$plenofix" info t.plut --devices
# A kernel cache that cannot be written: PoCL lists no device, and that is said.
if "$plenofix" devices | grep -q 'Portable Computing Language'; then
    POCL_CACHE_DIR=/dev/null/x "$plenofix" devices >out
    ! grep -q '^cl:' out && grep -q 'can it write its kernel cache' out
fi
# No driver: the list ends with what to do, not with an error.
OCL_ICD_VENDORS=/nonexistent "$plenofix" devices | grep -q 'install'

cat >s.json <<'JSON'
{"seed": 3, "rays": 2, "frames": ["white", "scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [30, 20]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 560}]}
JSON
"$plenofix" simulate s.json -o s
"$plenofix" calibrate s/white.png --bits 12 -o t.plut >/dev/null
depth() { "$plenofix" depth s/scene.png --bits 12 --lut t.plut "$@"; }
refused 2 'want cpu, cl or cl:N' depth -o d.pfm --device gpu
OCL_ICD_VENDORS=/nonexistent refused 1 'OpenCL' depth -o d.pfm --device cl
[ ! -e d.pfm ]
if ! "$plenofix" devices | grep -q '^cl:0'; then
    echo "no OpenCL device here: maps not compared"
    exit 0
fi
refused 2 'presets run on the core' depth -o d.pfm --device cl --preset stream
if "$plenofix" devices | grep -q 'Portable Computing Language'; then
    POCL_CACHE_DIR=/dev/null/x refused 1 'kernel cache' depth -o d.pfm --device cl
fi
refused 2 'there are' depth -o d.pfm --device cl:99
for method in binocular plenoptic sweep gradient; do
    depth --method $method -o cpu.pfm --confidence cpu.c.pfm --flags cpu.png >/dev/null
    depth --method $method -o cl.pfm --confidence cl.c.pfm --flags cl.png --device cl \
        >/dev/null
    cmp cpu.pfm cl.pfm
    cmp cpu.c.pfm cl.c.pfm
    cmp cpu.png cl.png
done

# A white frame is divided out on the host, folders of views go as they are: the same.
depth --white s/white.png -o cpu.pfm >/dev/null
depth --white s/white.png -o cl.pfm --device cl >/dev/null
cmp cpu.pfm cl.pfm
# A camera's frames, live, one unlike the other: one context, the tone of each.
"$plenofix" record s/white.png s/scene.png --bits 12 -o f.plxr >/dev/null
live() { "$plenofix" live f.plxr --speed 0 --lut t.plut --slopes 0:0.2:11 "$@" >/dev/null; }
for method in sweep plenoptic; do
    live --method $method --pfm cpu.pfm
    live --method $method --pfm cl.pfm --device cl
    cmp cpu.pfm cl.pfm
done
refused 2 'wants a --method' "$plenofix" live s/scene.png --lut t.plut --slopes 0:0.2:11 \
    --device cl
