#!/bin/bash
# SPDX-License-Identifier: MIT
# From frames to displacements to packets and back; gaps, late frames, bad input.
set -eu
plenofix=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

cat >s.json <<'JSON'
{"seed": 3, "rays": 2, "frames": ["scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [36, 28]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 560}]}
JSON
"$plenofix" simulate s.json -o a
sed 's/"z_mm": 560/"z_mm": 700/' s.json >t.json
"$plenofix" simulate t.json -o b
size=$(od -An -tu1 -j16 -N8 a/scene.png | awk '{print $3*256+$4 "x" $7*256+$8}')
"$plenofix" import-centres a/centres.csv --size "$size" --bits 12 -o t.plut >/dev/null
printf 'i,j,hx,hy,reference\n10,9,3,4,0\n22,9,3,4,0\n18,20,4,3,0\n2,2,3,3,0\n' >r.csv
mkdir f
for n in 00 01 02 03 04 05 06 08; do cp a/scene.png f/f_$n.png; done
for n in 09 10 11; do cp b/scene.png f/f_$n.png; done
monitor() { "$plenofix" monitor "$@" --lut t.plut --regions r.csv --bits 12 --quiet; }

monitor f -o s.csv --rest 4 --rate 100 --packets p.bin --uff u.uff --modes 10:0.02 >log
grep -q '^7 frames, 4 regions, 1 lost, 0 late' log
grep -q '^mode 10 Hz: not found' log
head -1 s.csv | grep -q '^frame,time_s,region,u_pitch,v_pitch,w_slope,'
[ "$(wc -l <s.csv)" = 29 ]
# The rest state itself reads zero; the region at the rim is flagged EDGE and empty.
awk -F, 'NR > 1 && $1 < 9 && $3 < 3 && ($4^2 + $5^2 + $6^2 > 1e-9 || $12 != 0) {exit 1}' s.csv
awk -F, 'NR > 1 && $3 == 3 && ($4 != "" || $12 != 8) {exit 1}' s.csv
# Another plane with another texture: flagged, never measured in silence.
awk -F, '$1 > 8 && $3 < 3 && $12 == 0 {exit 1}' s.csv
[ "$(grep -c '^    58$' u.uff)" = 12 ]

"$plenofix" decode p.bin -o d.csv --modes m.csv >log
grep -q '^7 packets, 0 lost, 0 damaged places' log
[ "$(wc -l <d.csv)" = 29 ]
awk -F, 'FNR == NR {if (FNR > 1) w[$3 "," $2] = $6; next}
    FNR > 1 && $7 == 0 && ($5 - w[$2 "," $1])^2 > 4e-12 {exit 1}' s.csv d.csv
{ head -c 70 p.bin; tail -c +80 p.bin; } >cut.bin
"$plenofix" decode cut.bin -o d2.csv >log
grep -q '1 lost, 1 damaged places' log

monitor f/f_00.png f/f_01.png f/f_05.png f/f_03.png f/f_06.png -o l.csv --rest 2 >log 2>err
grep -q '1 late' log && grep -q 'goes back in time' err

# A plane that swings at an eighth of the rate: the mode is found without a hint, the
# packets fit the link, the outputs agree.
for z in 561 562 563; do
    sed "s/\"z_mm\": 560/\"z_mm\": $z/" s.json >z.json
    "$plenofix" simulate z.json -o z$z
done
mkdir swing
for n in $(seq 100 231); do
    case $((n % 8)) in
    0 | 4) from=a ;;
    1 | 3) from=z561 ;;
    2) from=z562 ;;
    *) from=a ;;
    esac
    ln -s ../$from/scene.png swing/f_$n.png
done
awk -F, -v OFS=, 'NR == 1 {print $0, "x_mm,y_mm,z_mm"; next}
    {print $0, 1.125 * $1, -2.5 * NR, 7}' r.csv >places.csv
mv places.csv r.csv
monitor swing -o w.csv --rest 1 --rate 160 --modes auto --report r.html --packets w.bin \
    --link 57600 --uff w.uff >log
grep -Eq '^mode (19\.9[0-9]*|20(\.0[0-9]*)?) Hz: (19\.9|20\.0)[0-9]* ' log
[ $(($(wc -c <w.bin) * 8 * 160)) -le $((57600 * 131)) ]
# Where the regions lie goes along: the file of regions asked for it.
head -1 w.csv | grep -q ',flags,x_mm,y_mm,z_mm$'
[ "$(sed -n 3p w.csv | cut -d, -f13-)" = 24.75,-7.5,7 ]
grep -A3 '^    15$' w.uff | sed -n 3p | grep -Eq '^ +2 +0 +0 +0 +2\.47500E\+01 -7\.50000E\+00 +7\.0'
[ "$(grep -c '^   164$' w.uff)" = 1 ] && [ "$(grep -c '^    58$' w.uff)" = 12 ]
"$plenofix" decode w.bin -o w2.csv >log
grep -q ' 0 lost, 0 damaged places' log
grep -q '<h2>Modes</h2>' r.html
! grep -Eq 'src=|href=|https?:' r.html
monitor f -o s.csv --rest 4 --rate 100 --modes auto --report r.html >log
grep -q 'No spectrum' r.html
if monitor f -o s.csv --rest 4 --hdf5 s.h5 >/dev/null 2>err; then
    [ "$(od -An -c -N4 s.h5 | tr -d ' ')" = '211HDF' ]
else
    grep -q 'without HDF5' err
fi

# At 30 Hz is nothing but what leaks of the others: no number for it.
monitor swing -o w.csv --rest 1 --rate 160 --modes 20:0.01,40:0.01,60:0.01,30:0.01 >log
grep -Eq '^mode 20 Hz: (19\.9|20\.0)[0-9]* ' log
grep -q '^mode 30 Hz: not found: what leaks of the other modes' log

# Regions off the lattice, without texture; frames lost, a light that goes out and comes
# back: flags, empty fields, never a number without one.
cat >g.json <<'JSON'
{"seed": 3, "rays": 1, "frames": ["scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [36, 28]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 560, "texture": {"pattern": "none", "mean": 0.5}}]}
JSON
"$plenofix" simulate g.json -o flat
for name in dim dark; do
    [ $name = dim ] && exposure=0.18 || exposure=0.01
    sed "s/\"full_well_e\": 30000/&, \"exposure\": $exposure/" s.json >l.json
    "$plenofix" simulate l.json -o $name
done
mkdir lamp
for n in 00 01 02 03 04 08; do ln -s ../a/scene.png lamp/f_$n.png; done
ln -s ../dim/scene.png lamp/f_05.png
ln -s ../dark/scene.png lamp/f_06.png
printf 'i,j,hx,hy\n10,9,3,4\n900,9,3,4\n-40,9,3,4\n35,27,3,3\n' >r.csv
monitor lamp -o lamp.csv --rest 4 --modes 10 >log
grep -q '^4 frames, 4 regions, 1 lost' log
awk -F, 'NR > 1 && $3 > 0 && ($4 != "" || $5 != "" || $6 != "" || $12 != 8) {exit 1}' lamp.csv
awk -F, '$3 == 0 && ($1 == 4 || $1 == 8) && $12 != 0 {exit 1}' lamp.csv
awk -F, '$3 == 0 && ($1 == 5 || $1 == 6) {n += $12 >= 128} END {exit n != 2}' lamp.csv
awk -F, '$1 == 7 {exit 1}' lamp.csv
[ "$(awk -F, '$1 == 8 {print $2; exit}' lamp.csv)" = 0.020000 ]
mkdir plain
for n in 0 1 2 3 4 5; do ln -s ../flat/scene.png plain/f_$n.png; done
printf 'i,j,hx,hy\n10,9,3,4\n' >r.csv
monitor plain -o flat.csv --rest 4 >log
awk -F, 'NR > 1 && ($4 != "" || $12 != 1) {exit 1}' flat.csv

bad() { # exit status wanted, words wanted, command
    local want=$1 words=$2 got=0
    shift 2
    "$@" >/dev/null 2>err || got=$?
    [ $got = "$want" ] && grep -q "$words" err ||
        { echo "$*: exit $got, $(cat err); want $want, $words"; exit 1; }
}
bad 2 'want --lut' "$plenofix" monitor f -o x.csv
bad 1 'want more than' monitor f/f_00.png -o x.csv
bad 2 'modes' monitor f -o x.csv --modes 120
bad 1 'no packet' "$plenofix" decode s.csv -o x.csv
bad 2 'packet file' "$plenofix" decode
printf 'i,j,hx\n1,1,1\n' >r.csv
bad 1 'no column hy' monitor f -o x.csv
printf 'i,j,hx,hy\n9,9,99,3\n' >r.csv
bad 1 'half sizes' monitor f -o x.csv
printf 'i,j,hx,hy,x_mm\n9,9,3,3,1\n' >r.csv
bad 1 'all of x_mm, y_mm, z_mm or none' monitor f -o x.csv
printf 'i,j,hx,hy,x_mm,y_mm,z_mm\n9,9,3,3,1,2,\n' >r.csv
bad 1 'region 0: want x_mm' monitor f -o x.csv
{ echo i,j,hx,hy; for n in $(seq 65); do echo $n,9,1,1; done; } >r.csv
bad 1 '65 regions, want 1 to 64' monitor f -o x.csv
[ ! -e x.csv ]
printf 'i,j,hx,hy\n10,9,3,4\n12,9,3,4\n' >r.csv
mkdir many
(cd many && seq -f 'f_%06g.png' 0 65536 | xargs touch)
bad 1 'too many files (65536)' monitor many -o x.csv
rm -rf many
monitor f -o x.csv --rest 4 >log 2>err
grep -q 'overlap: their errors are not independent' err
echo "monitor and decode work"
