#!/bin/bash
# SPDX-License-Identifier: MIT
# Bad input to the commands that measure: the right exit status, one line that names the
# trouble, no file left behind, nothing written over.
set -eu
plenofix=$(realpath "$1")
here=$(dirname "$(realpath "$0")")
dir=$(mktemp -d)
mounted=
trap '[ -z "$mounted" ] || umount "$dir/$mounted"; rm -rf "$dir"' EXIT
cd "$dir"
count=0

cat >s.json <<'JSON'
{"seed": 4, "rays": 1, "frames": ["scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [20, 16]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 560}]}
JSON
"$plenofix" simulate s.json -o s
cp s/scene.png raw.png
size=$(od -An -tu1 -j16 -N8 raw.png | awk '{print $3*256+$4 "x" $7*256+$8}')
"$plenofix" import-centres s/centres.csv --size "$size" --bits 12 -o t.plut >/dev/null
"$plenofix" views raw.png --bits 12 --lut t.plut -o v >/dev/null
w=${size%x*} h=${size#*x}
PYTHONPATH=$here python3 - "$w" "$h" <<'PY'
import os
import sys
import png
w, h = int(sys.argv[1]), int(sys.argv[2])
grey = lambda x, y: (x * 7 + y * 13) % 256
png.write("one.png", 1, 1, lambda x, y: 9)
png.write("other.png", w + 1, h, grey)
png.write("palette.png", w, h, lambda x, y: 0, colour=3,
          extra=png.chunk(b"PLTE", bytes(3)))
png.write("alpha.png", w, h, lambda x, y: (grey(x, y), 255), colour=4)
png.write("rgba.png", w, h, lambda x, y: (1, 2, 3, 4), colour=6)
png.write("clear.png", w, h, grey, extra=png.chunk(b"tRNS", bytes(2)))
png.write("deep.png", w, h, lambda x, y: 5000, depth=16)
png.write("black.png", w, h, lambda x, y: 0, depth=16)
png.write("flat.png", w, h, lambda x, y: 2000, depth=16)
os.makedirs("grid")
for k in range(9):
    png.write("grid/in_%d.png" % k, 40, 30, grey)
os.makedirs("odd")
for k in range(9):
    png.write("odd/in_%d.png" % k, 40 + (k == 3), 30, grey)
os.makedirs("small")
for k in range(9):
    png.write("small/in_%d.png" % k, 5, 5, grey)
data = bytearray(open("t.plut", "rb").read())
for name, at in (("magic", 0), ("header", 33), ("body", len(data) - 9)):
    bad = bytearray(data)
    bad[at] ^= 16
    open(name + ".plut", "wb").write(bad)
open("short.plut", "wb").write(data[:-20])
open("empty.plut", "wb").write(b"")
PY
head -c 3000 raw.png >cut.png
head -c 20 raw.png >head.png
printf 'P5\n1 1\n255\nx' >pgm.png
echo keep >keep.pfm

# refused STATUS TEXT ARGUMENTS: as said above.  keep.pfm must stay what it was.
bad() { # TEXT ARGUMENTS of refused
    echo "$@"
    cat err.txt
    exit 1
}
refused() {
    local want=$1 text=$2 status=0 before after line rest keep
    shift 2
    before=$(find .)
    "$plenofix" "$@" >out.txt 2>err.txt || status=$?
    after=$(find .)
    { IFS= read -r line; IFS= read -r rest; } <err.txt || true
    [ "$status" = "$want" ] || bad "status $status, want $want:" "$@"
    [ -n "$line" ] && [ -z "$rest" ] || bad "not one line:" "$@"
    grep -q -- "^plenofix: .*\($text\)" err.txt || bad "want '$text':" "$@"
    [ "$before" = "$after" ] || bad "files changed:" "$@"
    read -r keep <keep.pfm
    [ "$keep" = keep ] || bad "written over:" "$@"
    count=$((count + 1))
}
touch err.txt out.txt
depth() { # STATUS TEXT options
    local want=$1 text=$2
    shift 2
    refused "$want" "$text" depth raw.png --bits 12 --lut t.plut -o keep.pfm "$@"
}
frame() { # TEXT FILE options: a bad frame of any sort
    local text=$1 file=$2
    shift 2
    refused 1 "$text" depth "$file" --lut t.plut -o keep.pfm "$@"
}
everywhere() { # the same, by every command and option that takes one
    frame "$@"
    local text=$1 file=$2
    shift 2
    refused 1 "$text" views "$file" --lut t.plut -o none "$@"
    refused 1 "$text" refocus "$file" --lut t.plut --slope 0 -o keep.pfm "$@"
    refused 1 "$text" depth raw.png --lut t.plut --dark "$file" -o keep.pfm "$@"
    refused 1 "$text" depth raw.png --lut t.plut --white "$file" -o keep.pfm "$@"
}

# Frames.
everywhere 'absent.png' absent.png --bits 12
everywhere 'damaged PNG' cut.png --bits 12
frame 'damaged PNG' head.png --bits 12
frame '1 x 1\|one.png' one.png
everywhere 'palette' palette.png
frame 'transparency' alpha.png
frame 'transparency' rgba.png
frame 'transparency' clear.png
frame 'neither PNG nor TIFF' pgm.png
frame 'over the 4095 of 12 bits' deep.png --bits 12
refused 1 "use the table of this camera" depth other.png --lut t.plut -o keep.pfm
refused 1 'too little texture\|black' depth black.png --bits 12 --lut t.plut -o keep.pfm
refused 1 'give --slopes' depth flat.png --bits 12 --lut t.plut -o keep.pfm
refused 1 'is a folder\|Is a directory' depth s --lut t.plut -o keep.pfm

# Tables.
for t in magic header body empty; do
    refused 1 'lens table' depth raw.png --bits 12 --lut $t.plut -o keep.pfm
    refused 1 'lens table' info $t.plut
done
refused 1 'cut short' info short.plut
refused 1 'no lens table' info raw.png
refused 1 'absent.plut' info absent.plut
sed 's/"lenses": \[20, 16\]/"lenses": [14, 16]/' s.json >camera2.json
"$plenofix" simulate camera2.json -o s2
refused 1 'use the table of this camera' depth s2/scene.png --bits 12 --lut t.plut \
    -o keep.pfm
depth 1 'take it with the same camera' --dark s2/scene.png
depth 1 'use the table of this camera' --white s2/scene.png

# Options.
depth 2 'outside the lens' --radius 9
depth 2 'outside the lens' --method gradient --step 9
refused 2 'outside the lens' views raw.png --bits 12 --lut t.plut -o none --radius 9
refused 2 'outside the lens' views raw.png --bits 12 --lut t.plut -o none --views all \
    --radius 9
refused 2 'outside the lens' refocus raw.png --bits 12 --lut t.plut -o keep.pfm --slope 0 \
    --radius 9
depth 2 'MIN:MAX:N' --slopes 1
depth 2 'MIN:MAX:N' --slopes 0:1:8x
depth 2 'MIN under MAX' --slopes 1:-1:8
depth 2 'MIN under MAX' --slopes nan:1:8
depth 2 'MIN under MAX' --slopes 0:99:8
depth 2 'out of range' --slopes -9:9:8
depth 2 'farther than it is wide' --slopes -7:7:8
depth 2 '3 to 256 slopes' --slopes -1:1:2
depth 2 '3 to 256 slopes' --slopes -1:1:257
depth 2 'odd number' --window 8
depth 2 'from 3 to 31' --window 33
depth 2 'from 3 to 31' --window 9.5
depth 2 'larger than a view' --window 17
depth 2 'one of binocular|plenoptic|sweep|gradient' --method best
depth 2 'sums SAD only' --method sweep --cost zncc
depth 2 'takes 2' --method binocular --views 5
depth 2 'multiple of 4' --views 8
depth 2 'both axes' --method gradient --axes u
depth 2 'no option --windw' --windw 9
depth 2 'after it' --window
depth 2 'takes no value' --json=1
depth 2 'two outputs' --confidence keep.pfm
depth 2 'optics' --depth-mm mm.pfm
depth 2 'not both' --views-dir grid --grid 3x3
refused 2 'one operand too many' depth raw.png raw.png --lut t.plut -o keep.pfm
refused 2 'want a raw frame' depth --lut t.plut -o keep.pfm
refused 2 'want --lut' depth raw.png -o keep.pfm
refused 2 'want -o' depth raw.png --lut t.plut
refused 2 'want -o' views raw.png --lut t.plut
refused 2 'want --slope' refocus raw.png --lut t.plut -o keep.pfm
refused 2 'no command deepth' deepth
refused 2 'want a command'

# Folders of views.
grid() { # STATUS TEXT options
    local want=$1 text=$2
    shift 2
    refused "$want" "$text" depth -o keep.pfm "$@"
}
grid 1 'wants 12; move the others away' --views-dir grid --grid 3x4
grid 2 'ROWSxCOLUMNS' --views-dir grid --grid 3
grid 2 'ROWSxCOLUMNS' --views-dir grid --grid 0x9
grid 2 'give --grid' --views-dir grid
grid 1 'absent' --views-dir absent --grid 3x3
grid 1 'where the first view' --views-dir odd --grid 3x3 --slopes -1:1:9
grid 2 'larger than a view' --window 9 --views-dir small --grid 3x3 --slopes -1:1:9
grid 1 'too few views' --views-dir grid --grid 1x9 --method gradient --slopes -1:1:9
cp grid/in_0.png grid/again_7.png
grid 1 '10 numbered PNG files where --grid 3x3 wants 9' --views-dir grid --grid 3x3
"$plenofix" depth --views-dir grid --grid 3x3 --pattern 'in_*' --slopes -1:1:9 \
    -o ok.pfm >/dev/null 2>warned
grep -q 'ignored are 1 PNG files .* of the pattern: again_7.png' warned
rm grid/again_7.png
cp grid/in_0.png grid/mask.png
"$plenofix" depth --views-dir grid --grid 3x3 --slopes -1:1:9 -o ok2.pfm >/dev/null 2>warned
cmp ok.pfm ok2.pfm
grep -q 'ignored are 1 PNG files .*: mask.png' warned
rm ok.pfm ok2.pfm

# Files that tell sign and units.
sign() { # TEXT, what sed makes of v/views.json
    mkdir -p v2
    cp v/* v2
    sed "$2" v/views.json >v2/views.json
    refused 1 "$1" depth --views-dir v2 -o keep.pfm
}
sign '"sign" must read' 's/moves with/moves against/'
sign '"units" must read' 's/sensor pixels/millimetres/'
sign '"bits" must be' 's/"bits": 12/"bits": 16/'
sign '"lattice" is missing' 's/"lattice"/"latice"/'
sign 'must be two whole numbers' 's/"a_q22": \[/"a_q22": [0.5,/'
sign '"u" must be a number' 's/"u": [-0-9.]*/"u": 900/'
sign 'without a "file"' 's/"file"/"name"/'
sign 'of its folder' 's#view_000.png#../v/view_000.png#'
sign 'view_999.png' 's/view_000.png/view_999.png/'
sign 'line' 's/}$//'
rm -r v2
optics() { # TEXT, JSON
    echo "$2" >o.json
    depth 1 "$1" --optics o.json --depth-mm mm.pfm
}
optics 'wrong sign' '{"inv0": 2, "gain": 5.0}'
optics 'wrong sign' '{"inv0": 2, "gain": 0}'
optics '"gain" is missing' '{"inv0": 2}'
optics 'out of range' '{"inv0": 2000, "gain": -5.0}'
optics '"F_mm" must be' \
    '{"F_mm": 0.05, "focus_mm": 480, "f_mu_mm": 0.5, "pixel_mm": 0.0074, "pitch_mm": 0.125}'
optics '"pixel_mm" must be' \
    '{"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pixel_mm": 7.4, "pitch_mm": 0.125}'
optics 'must be over "F_mm"' \
    '{"F_mm": 50, "focus_mm": 48, "f_mu_mm": 0.5, "pixel_mm": 0.0074, "pitch_mm": 0.125}'
optics '"f_mu_mm" is missing' '{"F_mm": 50, "focus_mm": 480}'
optics 'o.json: line' '{"inv0": 2,'
optics 'JSON object' '[1, 2]'

printf '0.1,500\n' >t.csv
refused 1 'two targets' optics t.csv -o keep.pfm
printf '0.1,500\n0.1,600\n' >t.csv
refused 1 'two targets' optics t.csv -o keep.pfm
printf '0.1,500\n0.2,-1\n' >t.csv
refused 1 'target 2' optics t.csv -o keep.pfm
printf 'a,b\n0.1,500\n' >t.csv
refused 1 'slope,distance_mm' optics t.csv -o keep.pfm
refused 2 'want TARGETS.csv' optics t.csv

# Lists of centres.
centres() { # STATUS TEXT LINES options
    local want=$1 text=$2 lines=$3
    shift 3
    printf '%b' "$lines" >c.csv
    refused "$want" "$text" import-centres c.csv -o keep.pfm --size "$size" "$@"
}
centres 1 'no row of numbers' ''
centres 1 'want columns' 'a,b\n1,2\n'
centres 1 'line 3: not a row of numbers' '1,2\n3,4\nfive,6\n'
centres 1 'line 2: 3 fields' '1,2\n3,4,5\n'
centres 1 'centres; want 9' '0,0,1,2\n'
centres 1 'no lattice' "$(seq -f '%g,7\n' 1 20 | tr -d '\n')"
sed '3p' s/centres.csv >c.csv
refused 1 'two points for row 0, column 1' import-centres c.csv -o keep.pfm --size "$size"
refused 2 'want --size' import-centres s/centres.csv -o keep.pfm
refused 2 'WIDTHxHEIGHT' import-centres s/centres.csv -o keep.pfm --size 7
refused 2 'half the lens pitch' import-centres s/centres.csv -o keep.pfm --size "$size" --radius 12

# Where the output cannot go.
nowhere() { # TEXT PATH
    refused 1 "$1" depth raw.png --bits 12 --lut t.plut -o "$2"
    refused 1 "$1" depth raw.png --bits 12 --lut t.plut -o keep.pfm --confidence "$2"
    refused 1 "$1" refocus raw.png --bits 12 --lut t.plut --slope 0 -o "$2"
    refused 1 "$1" import-centres s/centres.csv --size "$size" -o "$2"
    refused 1 "$1" info t.plut --centres "$2"
    refused 1 "$1" info t.plut --c-array "$2"
}
nowhere 'make the folder first' none/out.pfm
nowhere 'it is a folder' grid
refused 1 'a file of that name' views raw.png --bits 12 --lut t.plut -o keep.pfm
refused 1 'cannot make the folder' views raw.png --bits 12 --lut t.plut -o none/none
mkdir locked
chmod 555 locked
if [ "$(id -u)" != 0 ]; then
    nowhere 'a folder you may write to' locked/out.pfm
elif [ -d /sys/kernel ]; then
    nowhere 'a folder you may write to' /sys/kernel/out.pfm
else
    echo "skipped: read-only folder (root writes anywhere, no /sys)"
fi
full() { # TEXT PATH: what fails only when the bytes are written
    refused 1 "$1" depth raw.png --bits 12 --lut t.plut -o "$2"
    refused 1 "$1" import-centres s/centres.csv --size "$size" -o "$2"
    refused 1 "$1" info t.plut --centres "$2"
    refused 1 "$1" refocus raw.png --bits 12 --lut t.plut --slope 0 -o "$2"
}
if [ -c /dev/full ]; then
    full 'free some space' /dev/full
else
    echo "skipped: disk full by /dev/full (there is none)"
fi
mkdir tiny
if mount -t tmpfs -o size=4k none tiny 2>/dev/null; then
    mounted=tiny
    head -c 4096 /dev/zero >tiny/filler || true
    full 'free some space' tiny/out.pfm
    refused 1 'free some space' views raw.png --bits 12 --lut t.plut -o tiny
else
    echo "skipped: disk full by a tmpfs (may not mount)"
fi
echo "ok: $count refusals"
