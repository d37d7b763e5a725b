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
    # False alarms, each looked at: loops over lanes or axes taken for ones that may not
    # run at all, and a workspace taken for the NULL of the dry run that sizes it.
    case $f in
    */kernels.c | */kernels_pair.c | */roi_solve.c) quiet=-Wno-analyzer-use-of-uninitialized-value ;;
    */refine.c) quiet=-Wno-analyzer-null-dereference ;;
    *) quiet= ;;
    esac
    # shellcheck disable=SC2086 # empty when there is none
    gcc -std=c99 -O0 -fanalyzer $quiet -Werror -I"$top/include" -I"$top/src" -c "$f"
done
echo "analyzer: nothing found in $# files"
