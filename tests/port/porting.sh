#!/bin/sh
# SPDX-License-Identifier: MIT
# The compiler's command lines of port/PORTING.md, as they stand there.
# usage: porting.sh SOURCE-ROOT
set -eu
root=$(realpath "$1")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cp -r "$root/include" "$root/src" "$root/port" "$dir"
cd "$dir"
sed -n 's/^    \(arm-none-eabi-gcc\|cc\) /\1 /p' port/PORTING.md >lines
[ "$(wc -l <lines)" = 3 ] || { echo "porting: three command lines were there"; exit 1; }
ran=0
while read -r line; do
    command -v "${line%% *}" >/dev/null || continue
    echo "$line"
    sh -c "$line"
    ran=$((ran + 1))
done <lines
[ $ran -gt 0 ] || exit 77
[ ! -x selftest ] || ./selftest | tail -n 1 | grep -q '^sound$'
echo "porting: $ran of 3 command lines hold"
