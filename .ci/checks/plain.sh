#!/bin/sh
# SPDX-License-Identifier: MIT
# The core builds by a plain compiler call, with no configure step, warnings as errors;
# stream.h does without arms of views when told so.
# usage: plain.sh [COMPILER [FILE.c ...]]
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
compiler=${1:-cc}
[ $# -gt 0 ] && shift
[ $# -gt 0 ] || set -- "$top"/src/*.c
command -v "$compiler" >/dev/null || {
    echo "skipped: no $compiler"
    exit 77
}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$compiler" -std=c99 -pedantic-errors -Wall -Wextra -Wconversion -Wsign-conversion \
    -Wshadow -Wvla -Wundef -Wcast-align -Wstrict-prototypes -Wmissing-prototypes \
    -Wpointer-arith -Wwrite-strings -Werror -O1 -I"$top/include" -c "$@"
"$compiler" -std=c99 -O1 -DPLFX_STREAM_ARMS=0 -I"$top/include" -c "$top/src/stream.c" -o bare.o
if nm -u bare.o | grep -E 'plfx_(arms|frame|median)_'; then
    echo "plain: -DPLFX_STREAM_ARMS=0 leaves these in"
    exit 1
fi
echo "plain: builds with $compiler"
