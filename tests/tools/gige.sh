#!/bin/bash
# SPDX-License-Identifier: MIT
# grab, record and live from a GigE Vision camera that serves a simulated frame.
# usage: gige.sh PLENOFIX SERVE CAMERA.xml
set -eu
# shellcheck source=tests/tools/served.sh
. "$(dirname "$0")/served.sh"

# The same, two pixels in three bytes (Mono12p).
python3 - f.raw f.p12 <<'PY'
import sys
v = open(sys.argv[1], 'rb').read()
p = [v[k] | v[k + 1] << 8 for k in range(0, len(v), 2)]
out = bytearray()
for a, b in zip(p[0::2], p[1::2]):
    out += bytes((a & 255, a >> 8 | (b & 15) << 4, b >> 4))
open(sys.argv[2], 'wb').write(out)
PY
"$plenofix" grab f.p12 --size "$size" --format mono12p -o g12.png >/dev/null

run() { # LOST COMMAND...
    lost=$1
    shift
    "$serve" "$xml" f.raw "$size" 0x01100007 "$lost" "$plenofix" "$@"
}

status=0
run 0 grab gige -o g.png >log || status=$?
[ "$status" != 77 ] || { cat log; exit 77; }
[ "$status" = 0 ]

# Served frame -> map is file -> map, to the bit, by both ways.
for f in g.png s/scene.png; do
    "$plenofix" depth "$f" --bits 12 --lut t.plut --slopes 0:0.2:21 -o "$(basename "$f").pfm" \
        >/dev/null
done
cmp g.png.pfm scene.png.pfm
# The camera's frames by a method of depth, packed on the wire: depth's own map.
for method in binocular plenoptic sweep gradient; do
    "$plenofix" depth s/scene.png --bits 12 --lut t.plut --slopes 0:0.2:21 \
        --method $method -o d.pfm >/dev/null
    "$serve" "$xml" f.p12 "$size" 0x010c0047 0 "$plenofix" live gige --lut t.plut \
        --slopes 0:0.2:21 --method $method --frames 2 --pfm l.pfm >/dev/null
    cmp d.pfm l.pfm
done
"$serve" "$xml" f.p12 "$size" 0x010c0047 0 "$plenofix" grab gige -o p.png >/dev/null
cmp p.png g12.png
live="--lut t.plut --slopes 0:0.2:21 --window 5"
# shellcheck disable=SC2086
run 0 live gige $live --frames 3 --pfm c.pfm -o c.png >log
[ "$(grep -c measured log)" = 3 ]
# shellcheck disable=SC2086
"$plenofix" live f.raw --size "$size" --format u16 $live --pfm f.pfm >/dev/null
cmp c.pfm f.pfm

# Lost packets: whole frames alone are recorded, the rest is named.
run 0.002 record gige --packet 1400 --frames 12 -o r.plxr >log 2>err
grep -q "12 frames recorded" log
grep -q "12 frames good, [1-9][0-9]* incomplete" err
"$plenofix" replay r.plxr --speed 0 -o r.png >log
for k in 00 05 11; do
    cmp g.png "r_00$k.png"
done

status=0
run 0 grab gige:nobody -o x.png 2>err || status=$?
[ "$status" = 1 ] && grep -q "gige:nobody cannot be opened" err
status=0
run 0 grab gige --format csi10 -o x.png 2>err || status=$?
[ "$status" = 1 ] && grep -q "cannot be set as wished" err
status=0
run 0 live gige --size 40x40 --lut t.plut --slopes 0:0.2:21 2>err || status=$?
[ "$status" = 1 ] && grep -q "is for $size pixels" err
[ ! -e x.png ]
echo "gige: all as it should be"
