#!/bin/sh
# SPDX-License-Identifier: MIT
# gcc's -fanalyzer over the core, at -O0: it is silent under the optimiser.
# usage: analyzer.sh [FILE.c ...]
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
[ $# -gt 0 ] || set -- "$top"/src/*.c
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
for f in "$@"; do
    gcc -std=c99 -O0 -fanalyzer -Werror -I"$top/include" -I"$top/src" -c "$f"
done
echo "analyzer: nothing found in $# files"
