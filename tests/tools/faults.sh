#!/bin/bash
# SPDX-License-Identifier: MIT
# What happens to cameras and disks: each is named, counted and survived.
# usage: faults.sh PLENOFIX SERVE CAMERA.xml
set -eu
# shellcheck source=tests/tools/served.sh
. "$(dirname "$0")/served.sh"

expect() { # STATUS PATTERN: of the command that `run` ran
    [ "$status" = "$1" ] || { echo "$said: status $status, not $1"; cat $out $err; exit 1; }
    [ -z "$2" ] || grep -q -- "$2" $err || { echo "$said: no '$2' in:"; cat $err; exit 1; }
}
run() { # FAULTS COMMAND...: status, out, err
    said="$*"
    local faults=$1
    shift
    status=0
    "$serve" "$xml" f.raw "$size" 0x01100005 "$faults" "$plenofix" "$@" >$out 2>$err ||
        status=$?
}
out=out err=err

live="--lut t.plut --slopes 0:0.2:11 --window 5 --rate 100"

# Absent; and where it is said which camera the frames are of.
run 0 grab gige --list
[ "$status" != 77 ] || { cat out; exit 77; }
expect 0 ''
camera=$(sed -n 's/.*, camera //p' out)
[ "$camera" -gt 0 ]
run 0 grab gige:nobody --list
expect 1 'gige:nobody cannot be opened'

# Unplugged: what was recorded stays, and is played.  Aravis takes 8 s to miss a camera.
unplugged() {
    out=out.gone err=err.gone
    run 0,gone=6 record gige --rate 20 -o gone.plxr
    expect 1 'the camera is gone'
    kept=$(sed -n 's/.*, \([0-9]*\) in all/\1/p' $out)
    [ "$kept" -ge 1 ] || exit 1
    [ "$("$plenofix" replay gone.plxr --speed 0 --list | grep -c ' frame ')" = "$kept" ]
}
unplugged_live() {
    out=out.live err=err.live
    # shellcheck disable=SC2086
    run 0,gone=6 live gige $live --rate 20
    expect 1 'the camera is gone'
    grep -q 'measured' $out
}
unplugged &
first=$!
unplugged_live &
second=$!

# Another size or format than the table's: refused or told of at the start ...
run 0 live gige --size 40x40 $live
expect 1 "is for $size pixels"
run 0 live gige --format u8 $live --frames 1
expect 0 't.plut is of frames of 12 bits, gige sends 8'
# ... and in the middle: counted, never shown.
for fault in small byte; do
    # shellcheck disable=SC2086
    run 0,$fault=9 live gige $live --timeout 2
    expect 1 'no frame within 2 s'
    grep -q '[1-9][0-9]* incomplete\|[1-9][0-9]* of another size' err
    ! grep -q ' 0.0 % measured' out
done

# The clock jumps back: counted, and the maps go on.
# shellcheck disable=SC2086
run 0,back=5 live gige $live --frames 12
expect 0 '1 times set back'
[ "$(grep -c measured out)" = 12 ]

# Table of another camera: refused live, and noted in what is recorded.
for id in "$camera" 7; do
    "$plenofix" import-centres s/centres.csv --size "$size" --bits 12 --camera "$id" \
        -o "c$id.plut" >/dev/null
done
run 0 live gige --lut "c$camera.plut" --slopes 0:0.2:11 --window 5 --frames 1
expect 0 ''
run 0 live gige --lut c7.plut --slopes 0:0.2:11 --window 5 --frames 1
expect 1 "c7.plut is of camera 7, gige is camera $camera"
run 0 record gige --lut c7.plut --frames 1 -o other.plxr
expect 1 'is of camera 7'
[ ! -e other.plxr ]
run 0 record gige --frames 2 -o mine.plxr
expect 0 ''
run 0 live mine.plxr --lut c7.plut --slopes 0:0.2:11 --window 5
expect 1 "c7.plut is of camera 7, mine.plxr is camera $camera"
status=0
"$plenofix" record s/scene.png --bits 12 --lut c7.plut --append -o mine.plxr 2>err ||
    status=$?
said=append expect 1 'another camera or table\|another kind'

# Disk full: the frames before it stay whole, and room lets it go on.
mkdir disk
if unshare -rm true 2>/dev/null; then
    cat >full.sh <<'SH'
mount -t tmpfs -o size=1m none disk || exit 77
status=0
"$1" record $(printf 's/scene.png %.0s' $(seq 40)) --bits 12 -o disk/d.plxr >out 2>err ||
    status=$?
"$1" replay disk/d.plxr --speed 0 --list >list || status=99
exit $status
SH
    status=0
    unshare -rm bash full.sh "$plenofix" || status=$?
    if [ $status != 77 ]; then
        said=full expect 1 'No space left'
        kept=$(sed -n 's/.*, \([0-9]*\) in all/\1/p' out)
        [ "$kept" -ge 2 ] && [ "$(grep -c ' frame ' list)" = "$kept" ]
    fi
fi
wait $first
wait $second
echo "faults: all as it should be"
