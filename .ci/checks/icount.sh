#!/bin/sh
# SPDX-License-Identifier: MIT
# Instructions a cell against tests/bench/icount.csv (2 %): every case of the common
# build, the matching of whole columns in C and AVX2 kernels for x86-64-v3.
set -eu
cd "$(dirname "$0")/../.."

count=tests/bench/icount.py
python3 $count build/tools/plenofix --check
grep -qw avx2 /proc/cpuinfo || exit 0
for kernels in c avx2; do
    folder=build-ci/icount-$kernels
    [ -f $folder/build.ninja ] || meson setup $folder -Dkernels=$kernels \
        -Dc_args=-march=x86-64-v3 -Dtests=disabled -Ddefault_library=static
    ninja -C $folder tools/plenofix
    build='x86-64-v3'
    [ $kernels = c ] || build="x86-64-v3 $kernels"
    python3 $count $folder/tools/plenofix --check --key "$build" --cases SAD
done
