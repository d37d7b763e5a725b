#!/bin/bash
# SPDX-License-Identifier: MIT
# plenofix depth without --slopes on 3x3 views of a box before a wall, drawn here: the
# range holds both and little else, whatever their sign, on views that are searched at
# half of their size (384 samples) as on those that are not (320).
set -eu
plenofix=$(realpath "$1")
here=$(cd "$(dirname "$0")" && pwd)
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

cat >draw.py <<'PY'
import os, random, struct, sys, zlib
import png
folder, n, wall, box = sys.argv[1], *map(int, sys.argv[2:])
os.mkdir(folder)
rng = random.Random(7)
side = n + 64
def texture(low):
    rows = []
    for _ in range(side // 4):
        at = [low + rng.randrange(100) for _ in range(side // 4 + 1)]
        row = bytes((at[x // 4] * (4 - x % 4) + at[x // 4 + 1] * (x % 4)) // 4
                    for x in range(side))
        rows += [row] * 4
    return rows
back, front = texture(20), texture(120)
def part(rows, y, x, w):
    return rows[y][x:x + w]
def noisy(row): # 0 .. 15 on every sample, which stays under 256
    n = len(row)
    more = int.from_bytes(rng.randbytes(n), "big") & int.from_bytes(b"\x0f" * n, "big")
    return (int.from_bytes(row, "big") + more).to_bytes(n, "big")
first, last = n * 3 // 10, n * 6 // 10
for k in range(9):
    u, v = k % 3 - 1, k // 3 - 1
    data = b""
    for y in range(n):
        row = part(back, y + 32 + wall * v, 32 + wall * u, n)
        if first <= y + box * v < last:
            x = first - box * u
            row = row[:x] + part(front, y + 32 + box * v, 32 + first, last - first) \
                + row[x + last - first:]
        data += b"\0" + noisy(row)
    with open("%s/v%d.png" % (folder, k), "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n"
                  + png.chunk(b"IHDR", struct.pack(">IIBBBBB", n, n, 8, 0, 0, 0, 0))
                  + png.chunk(b"IDAT", zlib.compress(data, 1)) + png.chunk(b"IEND", b""))
PY

found() { # folder, wall, box, options: the range of the slopes that were searched
    local folder=$1 wall=$2 box=$3
    shift 3
    "$plenofix" depth --views-dir "$folder" --grid 3x3 -o d.pfm "$@" >out.txt
    sed -n 's/^slopes searched: \([^:]*\):\([^:]*\):[0-9]*, found.*/\1 \2/p' out.txt |
        awk -v a="$wall" -v b="$box" '{
            n++; ok = $1 <= a && $1 >= a - 1.5 && $2 >= b && $2 <= b + 1.5
            } END {exit !(n == 1 && ok)}' ||
        { echo "want $wall .. $box ($folder, $*) in:"; cat out.txt; exit 1; }
}

for scene in "384 -3 2" "384 2 7" "320 -8 -5"; do
    read -r n wall box <<<"$scene"
    PYTHONPATH=$here python3 draw.py "s$n$wall$box" "$n" "$wall" "$box"
    found "s$n$wall$box" "$wall" "$box" --preset stream
done
found s384-32 -3 2

# Nothing to match in: said, and how to go on.
PYTHONPATH=$here python3 -c '
import os, png
os.mkdir("flat")
for k in range(9):
    png.write("flat/v%d.png" % k, 384, 384, lambda x, y: 90)'
status=0
"$plenofix" depth --views-dir flat --grid 3x3 --preset stream -o d.pfm 2>d.err || status=$?
[ $status = 1 ] && grep -q 'too little texture.*--slopes' d.err
echo ok
