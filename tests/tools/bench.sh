#!/bin/sh
# SPDX-License-Identifier: MIT
# plenofix bench: one round of every case, as text and as JSON.
set -eu
plenofix=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$plenofix" bench --rounds 1 >"$folder/text"
"$plenofix" bench --rounds 1 --json >"$folder/json"
for name in "SAD 640x480 16 labels 9x9" "NCC 640x480 17 labels 9x9" \
    "stream 5 views fast" "decode 13x13 views"; do
    grep -q "$name" "$folder/text" || { echo "text lacks $name"; exit 1; }
    grep -q "$name" "$folder/json" || { echo "JSON lacks $name"; exit 1; }
done
if "$plenofix" bench --rounds 0 2>"$folder/error"; then
    echo "zero rounds were accepted"
    exit 1
fi
grep -q -e --rounds "$folder/error"
