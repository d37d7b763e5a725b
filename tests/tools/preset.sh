#!/bin/bash
# SPDX-License-Identifier: MIT
# plenofix depth --preset on a grid of 5x5 views of a tilted plane drawn here.
set -eu
plenofix=$(realpath "$1")
here=$(cd "$(dirname "$0")" && pwd)
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"
mkdir good bad small

PYTHONPATH=$here python3 - <<'PY'
import math, struct
import png
W, H, N = 72, 60, 5
def truth(x, y):
    return 0.6 + 0.006 * (x - W / 2) - 0.004 * (y - H / 2)
def texture(x, y):
    return (32000 + 9000 * math.sin(0.9 * x + 0.4 * y) + 7000 * math.sin(0.7 * y - 0.6 * x)
            + 5000 * math.sin(1.3 * y + 0.2 * x + 2))
def view(u, v):
    def sample(x, y):
        # the point seen at (x, y): X = x + d(X, Y) u, linear in X and Y
        X, Y = x, y
        for _ in range(8):
            d = truth(X, Y)
            X, Y = x + d * u, y + d * v
        return int(texture(X, Y))
    return sample
for k in range(N * N):
    at = view(k % N - 2, k // N - 2)
    png.write("good/v%02d.png" % k, W, H, at, depth=16)
    png.write("bad/v%02d.png" % k, W, H, (lambda x, y: 0) if k == 14 else at, depth=16)
    png.write("small/v%02d.png" % k, W - (k == 14), H, at, depth=16)
with open("truth.pfm", "wb") as f:
    f.write(b"Pf\n%d %d\n-1\n" % (W, H))
    f.write(b"".join(struct.pack("<f", truth(x, H - 1 - y))
                     for y in range(H) for x in range(W)))
PY

figure() { # key, file: the first number after "key":
    sed -n "s/^ *\"$1\": \([-0-9.e]*\),*\$/\1/p" "$2" | head -1
}
under() { # name, value, limit
    awk -v v="$2" -v b="$3" 'BEGIN {exit !(v != "" && v <= b)}' ||
        { echo "$1 is $2, want at most $3"; exit 1; }
}
depth() { # folder, options
    local folder=$1
    shift
    "$plenofix" depth --views-dir "$folder" --grid 5x5 --slopes 0:1.2:13 -o d.pfm "$@"
}

for preset in stream onboard precise; do
    depth good --preset $preset --sigma s.pfm --json >d.json 2>d.err
    [ ! -s d.err ] || { cat d.err; exit 1; }
    grep -q "\"preset\": \"$preset\"" d.json
    "$plenofix" evaluate d.pfm truth.pfm --border 8 --json >e.json
    case $preset in
    stream) under "$preset median" "$(figure median_x100 e.json)" 3 ;;
    onboard) under "$preset median" "$(figure median_x100 e.json)" 0.8 ;;
    precise) under "$preset median" "$(figure median_x100 e.json)" 0.1 ;;
    esac
    under "$preset BadPix" "$(figure badpix_0.07 e.json)" 3
done

# A black view is named, left out, and costs little.
depth bad --preset onboard --json >d.json 2>d.err
grep -q 'view at (-2, 0) is dark and left out' d.err
[ "$(wc -l <d.err)" = 1 ]
[ "$(figure views_left_out d.json)" = 1 ]
"$plenofix" evaluate d.pfm truth.pfm --border 8 --json >e.json
under "BadPix without a view" "$(figure badpix_0.07 e.json)" 3

# Ranges that miss the scene are said; views of unequal size are refused.
"$plenofix" depth --views-dir good --grid 5x5 --slopes -1.5:-0.5:11 -o d.pfm \
    --preset onboard 2>d.err >/dev/null
grep -q 'ends of the slopes' d.err
status=0
depth small --preset onboard >/dev/null 2>d.err || status=$?
[ $status = 1 ] && grep -q 'v14.png' d.err
status=0
depth good --preset fast >/dev/null 2>d.err || status=$?
[ $status = 2 ] && grep -q 'onboard' d.err

# What a preset settles is refused beside it, and noise without one.
for o in "--method sweep" "--cost sad" "--fuse median" "--views 9" "--axes uv" --adjacent \
    "--step 1"; do
    status=0
    # shellcheck disable=SC2086
    depth good --preset onboard $o >/dev/null 2>d.err || status=$?
    [ $status = 2 ] && grep -q -- "${o%% *} has no effect with --preset" d.err
done
status=0
depth good --noise 1 >/dev/null 2>d.err || status=$?
[ $status = 2 ] && grep -q -- '--preset too' d.err
# Window and gates of the command line go before the preset's.
depth good --preset onboard --window 9 --unique 0.2 --json >d.json
[ "$(figure window d.json)" = 9 ]

# The methods leave out what they were to match, gradient refuses.
mkdir ring
cp good/* ring
cp bad/v14.png ring/v10.png
cp bad/v14.png ring/v11.png
for m in plenoptic sweep; do
    depth ring --method $m --json >d.json 2>d.err
    grep -q 'view at (2, 0) is dark and left out' d.err
    [ "$(figure views_left_out d.json)" = "$(wc -l <d.err)" ]
    "$plenofix" evaluate d.pfm truth.pfm --border 8 --json >e.json
    under "median of $m without views" "$(figure median_x100 e.json)" 3
done
status=0
depth ring --method gradient >/dev/null 2>d.err || status=$?
[ $status = 1 ] && grep -q 'all of its five views' d.err

# Nothing is compared with a centre view that is black; 255 of 8 bits is saturated too.
mkdir centre eight
cp good/* centre
cp bad/v14.png centre/v12.png
status=0
depth centre --preset onboard >/dev/null 2>d.err || status=$?
[ $status = 1 ] && [ "$(wc -l <d.err)" = 1 ] && grep -q 'centre view is dark' d.err
PYTHONPATH=$here python3 -c '
import png
for k in range(25):
    png.write("eight/v%02d.png" % k, 72, 60,
              lambda x, y: 255 if k == 14 or x < 6 else (7 * x * y + x * x) % 250)'
depth eight --preset onboard --json >d.json 2>d.err
grep -q 'view at (-2, 0) is saturated and left out' d.err
[ "$(figure saturated d.json)" = 360 ]

# A saturated view is named; a missing one is an error that names the grid.
mkdir clipped gap
cp good/* clipped && cp good/* gap
rm gap/v14.png
PYTHONPATH=$here python3 -c '
import png
png.write("clipped/v14.png", 72, 60, lambda x, y: 65535, depth=16)'
depth clipped --preset onboard --json >d.json 2>d.err
grep -q 'view at (-2, 0) is saturated and left out' d.err
[ "$(figure views_left_out d.json)" = 1 ]
"$plenofix" evaluate d.pfm truth.pfm --border 8 --json >e.json
under "BadPix without a saturated view" "$(figure badpix_0.07 e.json)" 3
status=0
depth gap --preset onboard >/dev/null 2>d.err || status=$?
[ $status = 1 ] && [ "$(wc -l <d.err)" = 1 ] && grep -q '24' d.err

# The band pass comes after views are judged: they are named and left out as before.
depth clipped --preset onboard --band-pass --json >d.json 2>d.err
grep -q 'view at (-2, 0) is saturated and left out' d.err
"$plenofix" evaluate d.pfm truth.pfm --border 8 --json >e.json
under "BadPix of the band" "$(figure badpix_0.07 e.json)" 3

# Confidence and standard error stand in every point.
depth good --preset onboard --ply p.ply --sigma s.pfm --confidence c.pfm >/dev/null
head -c 400 p.ply | grep -aq 'property float confidence'
head -c 400 p.ply | grep -aq 'property float sigma'
python3 - <<'PY'
import struct
data = open("p.ply", "rb").read()
head, body = data.split(b"end_header\n", 1)
sigma = [struct.unpack_from("<f", body, 20 * k + 16)[0] for k in range(len(body) // 20)]
assert len(sigma) == 72 * 60, len(sigma)
assert all(0 < s < 0.07 for s in sigma), (min(sigma), max(sigma))
PY

# The range is found when it is not given.
"$plenofix" depth --views-dir good --grid 5x5 -o d.pfm --preset onboard >/dev/null
"$plenofix" evaluate d.pfm truth.pfm --border 8 --json >e.json
under "BadPix with a range found" "$(figure badpix_0.07 e.json)" 3
echo ok
