#!/bin/bash
# SPDX-License-Identifier: MIT
# The process keeps its memory: maps of a lossy camera, one after the other, and no growth.
# usage: soak.sh PLENOFIX SERVE CAMERA.xml [SECONDS]     SECONDS: of each run; 6
set -eu
plenofix=$(realpath "$1") serve=$(realpath "$2") xml=$(realpath "$3") seconds=${4:-6}
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir"
cat >s.json <<'JSON'
{"seed": 4, "rays": 1, "frames": ["scene"],
 "camera": {"F_mm": 50, "focus_mm": 480, "f_mu_mm": 0.5, "pitch_mm": 0.125,
            "pixel_mm": 0.0074, "lenses": [24, 18]},
 "sensor": {"bits": 12, "full_well_e": 30000},
 "objects": [{"type": "plane", "z_mm": 560}]}
JSON
"$plenofix" simulate s.json -o s >/dev/null
size=$(od -An -tu1 -j16 -N8 s/scene.png | awk '{print $3*256+$4 "x" $7*256+$8}')
pixels=$((${size%x*} * ${size#*x}))
"$plenofix" import-centres s/centres.csv --size "$size" --bits 12 -o t.plut >/dev/null
"$plenofix" record s/scene.png --bits 12 -o f.plxr >/dev/null
tail -c +$((4096 + 64 + 1)) f.plxr | head -c $((2 * pixels)) >f.raw

soak() { # COMMAND...: resident KiB four times a second, while it runs
    rm -f pid rss
    # shellcheck disable=SC2016
    "$serve" "$xml" f.raw "$size" 0x01100005 0.01 \
        bash -c 'echo $$ >pid; exec "$@"' soak "$plenofix" "$@" >out 2>err &
    local server=$! until=$((SECONDS + seconds)) pid status=0
    while [ ! -s pid ]; do
        if ! kill -0 $server 2>/dev/null; then
            wait $server || status=$?
            [ $status = 77 ] && { cat out; exit 77; }
            break
        fi
        sleep 0.05
    done
    pid=$(cat pid)
    while [ $SECONDS -lt $until ]; do
        awk '/^VmRSS/ {print $2}' "/proc/$pid/status" >>rss || break
        sleep 0.25
    done
    kill -INT "$pid"
    wait $server || status=$?
    [ $status = 0 ] || { echo "soak: $*: status $status"; cat err; exit 1; }
    grep -q 'incomplete' err || { echo "soak: nothing was lost"; exit 1; }
    # Most of the second third against most of the last: the first warms up.
    frames=$(sed -n 's/.*: \([0-9]*\) frames recorded.*/\1/p' out)
    [ -n "$frames" ] || frames=$(grep -c '^frame ' out)
    awk -v what="$1" -v frames="$frames" '
        {v[NR] = $1}
        END {
            n = int(NR / 3)
            for (k = n + 1; k <= 2 * n; k++) if (v[k] > before) before = v[k]
            for (k = 2 * n + 1; k <= NR; k++) if (v[k] > after) after = v[k]
            printf "soak: %s: %d frames, %d samples, %d then %d KiB resident\n", what,
                frames, NR, before, after
            exit n < 3 || frames < 10 || after > before + 256
        }' rss
}
soak live gige --lut t.plut --slopes 0:0.2:11 --window 5 --rate 50 --pfm m.pfm -o m.png
soak record gige --rate 50 -o r.plxr
echo "soak: no growth"
