#!/bin/bash
# SPDX-License-Identifier: MIT
# record, replay, live: frames in, the same frames and their map out; bad input.
set -eu
plenofix=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

fail() { # STATUS PATTERN COMMAND...: that status, one line on stderr with the pattern
    want=$1 pattern=$2
    shift 2
    status=0
    "$@" >out.txt 2>err.txt || status=$?
    [ "$status" = "$want" ] || { echo "$*: status $status, not $want"; cat err.txt; exit 1; }
    grep -q -- "$pattern" err.txt || { echo "$*: no '$pattern' in:"; cat err.txt; exit 1; }
}

cat >s.json <<'JSON'
{"seed": 4, "rays": 1, "frames": ["scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [24, 18]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 560}]}
JSON
"$plenofix" simulate s.json -o s >/dev/null
cp s/scene.png a.png
size=$(od -An -tu1 -j16 -N8 a.png | awk '{print $3*256+$4 "x" $7*256+$8}')
"$plenofix" import-centres s/centres.csv --size "$size" --bits 12 -o t.plut >/dev/null

# Pictures in, the same pictures out.
"$plenofix" record a.png a.png a.png --bits 12 --rate 100 -o f.plxr --lut t.plut >log
grep -q "3 frames recorded, 3 in all" log
"$plenofix" record a.png --bits 12 --append -o f.plxr --lut t.plut >log
grep -q "1 frames recorded, 4 in all" log
"$plenofix" replay f.plxr --speed 0 -o g.png >log
[ "$(grep -c ' frame ' log)" = 4 ]
"$plenofix" grab f.plxr -o one.png >/dev/null
for g in one g_0000 g_0001 g_0002 g_0003; do
    cmp one.png "$g.png"
done
"$plenofix" depth one.png --bits 12 --lut t.plut --slopes 0:0.2:21 -o one.pfm >/dev/null
"$plenofix" depth a.png --bits 12 --lut t.plut --slopes 0:0.2:21 -o a.pfm >/dev/null
cmp one.pfm a.pfm

# The map of a recording and of the picture are one.
live="--lut t.plut --slopes 0:0.2:21 --window 5 --frames 1"
# shellcheck disable=SC2086
"$plenofix" live f.plxr $live --pfm r.pfm -o r.png >log
grep -q "frame 0: [1-9][0-9.]* % measured" log
# shellcheck disable=SC2086
"$plenofix" live a.png $live --bits 12 --pfm p.pfm >/dev/null
cmp r.pfm p.pfm
[ -s r.png ]

# In its own time: the four frames span 20 ms and one jump back.
"$plenofix" replay f.plxr --list >/dev/null 2>err.txt
grep -q "1 times set back" err.txt

# Cut in the middle of a frame: two and a half frames are two.
bytes=$(stat -c %s f.plxr)
stride=$(((bytes - 4096) / 4))
head -c $((4096 + 2 * stride + stride / 2)) f.plxr >cut.plxr
"$plenofix" replay cut.plxr --speed 0 --list >log
[ "$(grep -c ' frame ' log)" = 2 ]
"$plenofix" record a.png --bits 12 --append -o cut.plxr >log 2>err.txt
grep -q "cut off [0-9]* bytes of an unfinished frame behind 2 whole ones" err.txt
grep -q "3 in all" log

# Bare frames.
head -c 4800 /dev/urandom >b.raw
"$plenofix" grab b.raw --size 40x40 --format mono12p --frames 2 -o b.png >/dev/null
[ -s b_0000.png ] && [ -s b_0001.png ]

fail 1 "is there already" "$plenofix" record a.png --bits 12 -o f.plxr
fail 1 "frames of another kind" "$plenofix" record a.png --append -o f.plxr
fail 1 "cannot be opened" "$plenofix" replay absent.plxr --list
cp t.plut t.plxr
fail 1 "is no recording" "$plenofix" replay t.plxr --list
fail 2 "want --size and --format" "$plenofix" grab b.raw -o x.png
fail 2 "want -o" "$plenofix" record a.png
fail 2 "want a camera" "$plenofix" record -o x.plxr
fail 2 "--slopes" "$plenofix" live f.plxr --lut t.plut
fail 2 "want --lut" "$plenofix" live f.plxr --slopes -1:1:5
fail 1 "is for $size pixels" "$plenofix" live b.raw --size 40x40 --format mono12p \
    --lut t.plut --slopes 0:0.2:21
fail 1 "cannot be opened" "$plenofix" grab v4l2:/dev/absent -o x.png
if [ -w /dev/full ]; then
    (ulimit -f 8 && trap '' XFSZ && fail 1 "File too large" \
        "$plenofix" record a.png a.png a.png --bits 12 -o full.plxr)
    rm -f full.plxr
fi
[ ! -e x.png ] && [ ! -e x.plxr ]
echo "record: all as it should be"
