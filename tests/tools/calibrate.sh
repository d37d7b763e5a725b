#!/bin/bash
# SPDX-License-Identifier: MIT
# plenofix calibrate on frames drawn here: figures, table, refusals.
set -eu
plenofix=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

python3 - <<'PY'
import math, random, struct, zlib
random.seed(7)
def png(path, w, h, px):
    def chunk(tag, data):
        body = tag + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
    raw = b"".join(b"\0" + bytes(px[y * w:(y + 1) * w]) for y in range(h))
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n"
                + chunk(b"IHDR", struct.pack(">IIBBBBB", w, h, 8, 0, 0, 0, 0))
                + chunk(b"IDAT", zlib.compress(raw, 1)) + chunk(b"IEND", b""))
def level(v):
    return max(0, min(255, int(v + 0.5)))
def dots(w, h, pitch, angle, x0, y0, nx, ny, dead=()):
    c, s = math.cos(angle) * pitch, math.sin(angle) * pitch
    im = [5.0] * (w * h)
    for j in range(ny):
        for i in range(nx):
            if (i, j) in dead:
                continue
            x, y = x0 + i * c - j * s, y0 + i * s + j * c
            for py in range(max(0, int(y) - 6), min(h, int(y) + 7)):
                for px in range(max(0, int(x) - 6), min(w, int(x) + 7)):
                    im[py * w + px] += 190 * math.exp(
                        -((px - x) ** 2 + (py - y) ** 2) / (2 * 1.6 ** 2))
    return [level(v + random.gauss(0, 1)) for v in im]
w, h = 260, 215
png("dots.png", w, h, dots(w, h, 14.5, math.radians(0.4), 20.25, 15.5, 16, 13, {(7, 6)}))
png("moved.png", w, h, dots(w, h, 14.5, math.radians(0.4), 20.75, 15.25, 16, 13))
png("other.png", w, h, dots(w, h, 13.1, math.radians(2), 14.5, 19.5, 16, 13))
png("few.png", 70, 70, dots(70, 70, 15.0, 0.0, 12.0, 12.0, 4, 4))
png("black.png", w, h, [level(random.gauss(0, 0.3)) for _ in range(w * h)])
png("white.png", w, h, [255] * (w * h))
png("flat.png", w, h, [120] * (w * h))
png("noise.png", w, h, [random.randrange(256) for _ in range(w * h)])
png("photo.png", w, h, [level(120 + 60 * math.sin(x * x / 4000) + 40 * math.cos(y / 17)
                              + random.gauss(0, 2)) for y in range(h) for x in range(w)])
def texture(name, light, turn=0.05):
    c, s, out = math.cos(turn), math.sin(turn), []
    for y in range(h):
        for x in range(w):
            out.append(level(random.gauss(sum(
                light(c * u - s * v, s * u + c * v) for u, v in
                ((x, y), (x + .5, y), (x, y + .5), (x + .5, y + .5))) / 4, 1.5)))
    png(name, w, h, out)
def even(a, b):
    return (math.floor(a) + math.floor(b)) % 2 == 0
texture("checker.png", lambda x, y: 220 if even(x / 11, y / 11) else 40)
texture("upright.png", lambda x, y: 220 if even(x / 10, y / 10) else 40, 0)
def brick(x, y):
    row = math.floor(y / 14)
    x += 14 * (row % 2)
    return 40 if y % 14 < 3 or x % 28 < 3 else 120 + 25 * math.sin(
        row * 12.9 + math.floor(x / 28) * 78.2)
texture("bricks.png", brick)
texture("mortar.png", lambda x, y: 240 - brick(x, y))
def window(x, y):
    n = math.sin(math.floor(x / 18) * 12.9898 + math.floor(y / 18) * 78.233)
    return 180 + 40 * n if x % 18 < 11 and y % 18 < 11 else 25
texture("windows.png", window)
texture("facade.png", lambda x, y: 205 - window(x, y))
PY

has() { grep -q -- "$2" "$1" || { echo "want $2 in:"; cat "$1"; exit 1; }; }
"$plenofix" calibrate dots.png -o cam.plut --json >out.json
python3 - <<'PY'
import json, math
d = json.load(open("out.json"))
l, n = d["lattice"], d["lenses"]
assert d["input"] == "dots" and d["verdict"] == "green", d
assert l["kind"] == "square" and (l["columns"], l["rows"]) == (16, 13), l
assert abs(l["pitch"] - 14.5) < 0.002, l
assert abs(l["rotation_deg"] - 0.4) < 0.01, l
assert math.hypot(l["origin"][0] - 20.25, l["origin"][1] - 15.5) < 0.01, l
assert n["found"] == 207 and n["missing"] == 1, n
assert d["table_bytes"] < 1600, d
PY
"$plenofix" calibrate dots.png -o again.plut >out.txt
has out.txt "^green: 207 lenses"
cmp cam.plut again.plut

refused() { # status, text, arguments
    local want=$1 text=$2 status=0
    shift 2
    "$plenofix" calibrate "$@" >out.txt 2>err.txt || status=$?
    [ "$status" = "$want" ] || { echo "status $status for $*"; cat err.txt; exit 1; }
    [ "$(wc -l <err.txt)" = 1 ]
    has err.txt "$text"
    [ ! -e none.plut ]
}
refused 1 "black" black.png -o none.plut
refused 1 "saturated" white.png -o none.plut
refused 1 "uniform" flat.png -o none.plut
refused 1 "no lens" noise.png -o none.plut
refused 1 "no lens" photo.png -o none.plut
for texture in checker upright bricks mortar windows facade; do
    refused 1 "no lens pattern" $texture.png -o none.plut
done
refused 1 "fewer than 5 x 5" few.png -o none.plut
refused 1 "one size" dots.png few.png -o none.plut
refused 1 "black.png: the frame disagrees" dots.png --white black.png -o none.plut
refused 1 "other.png: the frame disagrees" dots.png --white other.png -o none.plut
refused 1 "neither" dots.png --lattice hex -o none.plut
refused 1 "" absent.png -o none.plut
refused 2 "wants -o" dots.png
refused 2 "wants a frame" -o none.plut

# Report: one file, nothing fetched.
"$plenofix" calibrate dots.png -o cam.plut --report r.html >out.txt
has r.html "data:image/png;base64,"
has r.html "class='v green'"
if grep -q "http" r.html; then echo "the report refers to the network"; exit 1; fi

# Check: the same frame has not moved, a shifted one has, another camera's disagrees.
"$plenofix" check dots.png --lut cam.plut >out.txt
has out.txt "^not moved"
"$plenofix" check moved.png --lut cam.plut --json >out.json
python3 - <<'PY'
import json
d = json.load(open("out.json"))
assert d["moved"] and abs(d["shift"][0] - 0.5) < 0.01 and abs(d["shift"][1] + 0.25) < 0.01, d
PY
"$plenofix" views dots.png --lut cam.plut -o own >out.txt 2>err.txt
[ ! -s err.txt ]
"$plenofix" views other.png --lut cam.plut -o strange >out.txt 2>err.txt
has err.txt "warning: other.png: only"
for bad in noise.png few.png other.png; do
    status=0
    "$plenofix" check $bad --lut cam.plut >out.txt 2>err.txt || status=$?
    [ "$status" = 1 ] && [ "$(wc -l <err.txt)" = 1 ]
done

# Optics: the line through targets, its errors, its range.
"$plenofix" optics - -o o.json >out.txt 2>/dev/null && exit 1
printf 'slope,distance_mm\n0.1,1428.6\n0.05,870.0\n0.0,625.5\n-0.05,487.5\n-0.1,400.2\n' >t.csv
"$plenofix" optics t.csv -o o.json >out.txt
has out.txt "^1-sigma"
has out.txt "a hundredth of slope is"
python3 - <<'PY'
import json
o = json.load(open("o.json"))
assert abs(o["inv0"] - 1.6) < 4 * o["inv0_sigma"] and o["inv0_sigma"] < 0.01, o
assert abs(o["gain"] + 9.0) < 4 * o["gain_sigma"] and o["gain_sigma"] < 0.1, o
assert o["range_mm"] == [400.2, 1428.6], o
assert abs(o["mm_per_hundredth"][0] - 14.4) < 0.2, o
PY
