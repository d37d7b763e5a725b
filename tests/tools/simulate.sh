#!/bin/bash
# SPDX-License-Identifier: MIT
# plenofix simulate: files, the same bytes each run, refusals.
set -eu
plenofix=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"

scene() { # extra keys of the camera, extra keys of the scene
    cat <<JSON
{"seed": 5, "rays": 2, "frames": ["dots", "white", "dark", "scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [12, 9]$1},
 "sensor": {"bits": 10, "full_well_e": 20000},
 "objects": [{"type": "plane", "z_mm": 600},
             {"type": "box", "at_mm": [0, 0, 420], "size_mm": [6, 5, 3]}]$2}
JSON
}
refused() { # status, text, arguments
    local want=$1 text=$2 status=0
    shift 2
    "$plenofix" simulate "$@" >out.txt 2>err.txt || status=$?
    [ "$status" = "$want" ] || { echo "status $status for $*"; cat err.txt; exit 1; }
    [ "$(wc -l <err.txt)" = 1 ] || { cat err.txt; exit 1; }
    grep -q -- "$text" err.txt || { echo "want $text in:"; cat err.txt; exit 1; }
}
broken() { # sed expression, text
    scene "" "" | sed "$1" >bad.json
    refused 1 "$2" bad.json -o bad
    [ ! -e bad ]
}

scene "" "" >s.json
"$plenofix" simulate s.json -o a
"$plenofix" simulate s.json -o b
for f in dots.png white.png dark.png scene.png slope.pfm depth_mm.pfm objects.png \
    centres.csv optics.json scene_resolved.json
do
    [ -s "a/$f" ] || { echo "no $f"; exit 1; }
    cmp "a/$f" "b/$f"
done
[ "$(wc -l <a/centres.csv)" = 109 ]
head -1 a/centres.csv | grep -qx 'row,col,x,y'
sed 's/"seed": 5/"seed": 6/' s.json >other.json
"$plenofix" simulate other.json -o c
! cmp -s a/scene.png c/scene.png
scene ', "lattice": "hex", "dim": [[2, 3, 0.1], [4, 4, 0]], "stop_mm": [20, 14]' '' |
    sed 's/"bits": 10/"bits": 14, "bayer": "grbg", "colour": [0.7, 1, 0.8]/' >hex.json
"$plenofix" simulate hex.json -o d
[ -s d/scene.png ]

# A sequence: frames, truth, the same bytes each run.
wing() { # motion
    cat <<JSON
{"seed": 3, "rays": 1, "frames": [],
 "camera": {"F_mm": 50, "focus_mm": 500, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [14, 8]},
 "objects": [{"type": "wing", "at_mm": [0, 0, 500], "size_mm": [20, 12]},
             {"type": "plane", "z_mm": 700}],
 "motion": $1}
JSON
}
wing '{"frames": 3, "rate_hz": 200, "exposure_s": 0.002, "blur_steps": 2,
    "modes": [{"shape": "bend1", "hz": 6.2, "damping": 0.02, "damping_end": 0.005,
               "tip_rms_mm": 1}, {"shape": "torsion", "hz": 30, "tip_rms_mm": 0.2}],
    "shake_mm": 0.2, "shake_deg": 0.02, "flicker": 0.02, "stations": [[4, 10]]}' >w.json
"$plenofix" simulate w.json -o w1
"$plenofix" simulate w.json -o w2
cmp w1/frame_00002.png w2/frame_00002.png
cmp w1/motion.csv w2/motion.csv
! cmp -s w1/frame_00000.png w1/frame_00002.png
[ ! -e w1/scene.png ]
[ "$(wc -l <w1/motion.csv)" = 4 ]
grep -q '^frame,time_s,lamp,bend1_mm.*s0_w_mm,s0_col,s0_row,s0_slope$' w1/motion.csv
# Frames at rest come first: no motion, a steady lamp, noise of their own.
wing '{"rest": 2, "frames": 1, "flicker": 0.5, "shake_mm": 1, "stations": [[4, 10]],
    "modes": [{"shape": "bend1", "hz": 6.2, "tip_rms_mm": 1}]}' >w.json
"$plenofix" simulate w.json -o w3
[ "$(wc -l <w3/motion.csv)" = 4 ]
awk -F, 'NR == 2 || NR == 3 {if ($3 != 1 || $4 + $7 + $13 + $14 + $16 != 0) exit 1}
    NR == 4 {if ($2 != 0 || $4 == 0 || $7 == 0) exit 1}' w3/motion.csv
! cmp -s w3/frame_00000.png w3/frame_00001.png
wing '{"modes": [{"shape": "bend9", "hz": 6, "tip_rms_mm": 1}]}' >bad.json
refused 1 'bend1|bend2|torsion' bad.json -o bad
wing '{"stations": [[40, 1]]}' >bad.json
refused 1 'names no lens' bad.json -o bad
wing '{"rate_hz": 100, "exposure_s": 0.1}' >bad.json
refused 1 '"exposure_s" must be' bad.json -o bad

# Shot noise of small bright dots must not pass for damage: every lens is found.
scene ', "rotation_deg": 0.12, "blur_px": 0.25' '' |
    sed 's/\[12, 9\]/[70, 40]/; s/"bits": 10/"bits": 12, "offset": 64/' |
    sed 's/"dots", "white", "dark", "scene"/"dots"/' >many.json
"$plenofix" simulate many.json -o e
"$plenofix" calibrate e/dots.png --bits 12 -o e.plut >out.txt
grep -q '2800 found, 0 without light, 0 dim, 0 clipped, 0 interpolated' out.txt ||
    { cat out.txt; exit 1; }

broken 's/"F_mm": 50,//' '"F_mm" is missing'
broken 's/"focus_mm": 480/"focus_mm": 40/' 'beyond "F_mm"'
broken 's/"pitch_mm": 0.125/"pitch_mm": 0.01/' '4 to 100 pixels'
broken 's/"bits": 10/"bits": 17/' '"bits" must be a number from 8 to 14'
broken 's/"bits": 10/"bits": 10.5/' 'whole number'
broken 's/"bits"/"bit"/' 'no key "bit"'
broken 's/"plane"/"plain"/' 'plane|rect|box'
broken 's/\[12, 9\]/[12]/' 'list of 2 numbers'
broken 's/\[6, 5, 3\]/[6, 5]/' 'list of 3 numbers'
broken 's/"dots"/"spots"/' 'dots|white|dark|scene'
broken 's/"objects": \[/"objects": [7,/' 'want an object'
broken 's/"camera": {/"camera": {"dim": [[99, 0, 1]],/' 'names no lens'
broken 's/}$//' 'bad.json: line'
refused 1 absent.json absent.json -o bad
refused 1 'cannot make the folder' s.json -o s.json
refused 1 'cannot make the folder' s.json -o no/such/place
refused 2 'SCENE.json -o DIR' s.json
refused 2 'SCENE.json -o DIR' -o x
echo ok
