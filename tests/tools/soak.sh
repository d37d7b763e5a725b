#!/bin/bash
# SPDX-License-Identifier: MIT
# The process keeps its memory: maps of a lossy camera, one after the other, and no growth.
# usage: soak.sh PLENOFIX SERVE CAMERA.xml [SECONDS]     SECONDS: of each run; 6
set -eu
seconds=${4:-6}
# shellcheck source=tests/tools/served.sh
. "$(dirname "$0")/served.sh"

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
