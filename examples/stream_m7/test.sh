#!/bin/bash
# SPDX-License-Identifier: MIT
# A simulated frame through a bare Cortex-M7 under QEMU: its map is the host's, bit by bit.
# usage: test.sh PLENOFIX
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
plenofix=$(realpath "$1")
for tool in arm-none-eabi-gcc qemu-system-arm python3; do
    command -v $tool >/dev/null || {
        echo "skipped: no $tool (tools/setup ci)"
        exit 77
    }
done
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"
"$top/examples/stream_m7/build.sh" .
cat >s.json <<'JSON'
{"seed": 4, "rays": 1, "frames": ["scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [24, 18]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 560}]}
JSON
"$plenofix" simulate s.json -o s >/dev/null
size=$(od -An -tu1 -j16 -N8 s/scene.png | awk '{print $3*256+$4 "x" $7*256+$8}')
"$plenofix" import-centres s/centres.csv --size "$size" --bits 12 -o t.plut >/dev/null
"$plenofix" record s/scene.png --bits 12 -o f.plxr >/dev/null
tail -c +$((4096 + 64 + 1)) f.plxr | head -c $((2 * ${size%x*} * ${size#*x})) >f.raw

timeout 100 "$top/.ci/cross/qemu-m" mps2-an500 stream_m7.elf f.raw t.plut m.raw
"$plenofix" live f.raw --size "$size" --format u16 --bits 12 --lut t.plut \
    --slopes 0:0.2:21 --window 5 --pfm h.pfm >/dev/null
python3 - <<'PY'
import struct
import sys
data = open('h.pfm', 'rb').read()
head = data.split(b'\n', 3)
w, h = map(int, head[1].split())
order = '<' if float(head[2]) < 0 else '>'
host = struct.unpack(f'{order}{w * h}f', head[3])
bare = struct.unpack(f'<{w * h}i', open('m.raw', 'rb').read())
none = measured = 0
for j in range(h):
    for i in range(w):
        a, b = host[(h - 1 - j) * w + i], bare[j * w + i]
        if b == -2**31:
            none += 1
            if a == a:
                sys.exit(f'lens {i},{j}: the host measured {a}')
        elif round(a * 65536) != b:
            sys.exit(f'lens {i},{j}: host {a * 65536}, bare {b}')
        else:
            measured += 1
print(f'stream_m7: {w} x {h} lenses, {measured} measured, {none} not, '
      f'{len(set(bare))} slopes, all as on the host')
sys.exit(measured < w * h // 3 or len(set(bare)) < 10)
PY
status=0
"$top/.ci/cross/qemu-m" mps2-an500 stream_m7.elf absent.raw t.plut m2.raw || status=$?
[ "$status" = 1 ]
head -c 1000 f.raw >short.raw
status=0
"$top/.ci/cross/qemu-m" mps2-an500 stream_m7.elf short.raw t.plut m2.raw || status=$?
[ "$status" = 1 ]
