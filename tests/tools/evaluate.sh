#!/bin/bash
# SPDX-License-Identifier: MIT
# plenofix evaluate on maps made here: figures, picture, refusals.
set -eu
plenofix=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

python3 - <<'PY'
import struct
def pfm(path, w, h, value):
    with open(path, "wb") as f:
        f.write(b"Pf\n%d %d\n-1\n" % (w, h))
        f.write(b"".join(struct.pack("<f", value(x, h - 1 - y))
                         for y in range(h) for x in range(w)))
pfm("truth.pfm", 60, 50, lambda x, y: 0.01 * x)
pfm("same.pfm", 60, 50, lambda x, y: 0.01 * x)
pfm("off.pfm", 60, 50, lambda x, y: 0.01 * x + (0.05 if x < 30 else 0.0))
pfm("hole.pfm", 60, 50, lambda x, y: float("nan") if y < 25 else 0.01 * x)
pfm("wrong.pfm", 60, 50, lambda x, y: 0.01 * x + (0.1 if x < 30 else 0.0))
pfm("none.pfm", 60, 50, lambda x, y: float("nan"))
pfm("small.pfm", 10, 50, lambda x, y: 0.0)
PY

has() { grep -q -- "$2" "$1" || { echo "want $2 in:"; cat "$1"; exit 1; }; }
refused() { # status, text, arguments
    local want=$1 text=$2 status=0
    shift 2
    "$plenofix" evaluate "$@" >out.txt 2>err.txt || status=$?
    [ "$status" = "$want" ] || { echo "status $status for $*"; cat err.txt; exit 1; }
    [ "$(wc -l <err.txt)" = 1 ]
    has err.txt "$text"
}

"$plenofix" evaluate same.pfm truth.pfm >out.txt
has out.txt 'BadPix(0.01)      0.000 %'
"$plenofix" evaluate off.pfm truth.pfm --errors e.png --json >out.txt
has out.txt '"badpix_0.03": 50'
has out.txt '"badpix_0.07": 0'
has out.txt '"pixels": 600'
[ -s e.png ]
"$plenofix" evaluate hole.pfm truth.pfm --border 0 --json >out.txt
has out.txt '"missing": 1500'
has out.txt '"badpix_0.07": 50'
"$plenofix" evaluate same.pfm hole.pfm --border 0 --json >out.txt
has out.txt '"truth_missing": 1500'
"$plenofix" evaluate off.pfm truth.pfm --confidence truth.pfm --sigma same.pfm >out.txt
has out.txt 'kept by confidence'
has out.txt 'scatter / sigma'
# Half is bad; the half kept first by this confidence is not.
"$plenofix" evaluate wrong.pfm truth.pfm --confidence truth.pfm --border 0 >out.txt
has out.txt 'kept by confidence  100%:50.00 .* 60%:16.67 50%:0.00'

refused 1 '10x50' small.pfm truth.pfm
refused 1 'no pixel' same.pfm truth.pfm --border 25
refused 1 'no standard error' same.pfm truth.pfm --sigma none.pfm
refused 1 'absent.pfm' absent.pfm truth.pfm
refused 2 'two files' same.pfm
refused 2 'border' same.pfm truth.pfm --border x
echo ok
