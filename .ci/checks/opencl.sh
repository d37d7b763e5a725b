#!/bin/sh
# SPDX-License-Identifier: MIT
# The kernels as OpenCL C 1.2: no warning, no extension, valid SPIR-V, no float in it.
set -eu
cd "$(dirname "$0")/../.."
for tool in clang-14 llvm-spirv-14 spirv-val spirv-dis; do
    command -v $tool >/dev/null || { echo "skipped: $tool is not installed"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for f in src/cl/prelude.cl src/cl/params.h src/fix.h src/scalar.h src/gradient_scalar.h \
    src/depth_scalar.h src/cl/kernels.cl; do
    grep -v '^#include' $f
done >"$work/all.cl"
[ $# -eq 0 ] || cat "$1" >>"$work/all.cl" # a planted violation
flags="-x cl -cl-std=CL1.2 -Xclang -finclude-default-header -Xclang -cl-ext=-all"
# shellcheck disable=SC2086 # a list of flags
clang-14 $flags -target spir64-unknown-unknown -Wall -Wextra -Wconversion -Werror \
    -Wno-unused-function -fsyntax-only "$work/all.cl"
# shellcheck disable=SC2086
clang-14 $flags -target spir64-unknown-unknown -O0 -Xclang -disable-O0-optnone -emit-llvm \
    -c "$work/all.cl" -o "$work/all.bc"
llvm-spirv-14 --spirv-max-version=1.0 "$work/all.bc" -o "$work/all.spv"
spirv-val --target-env opencl1.2 "$work/all.spv"
floats=$(spirv-dis "$work/all.spv" | grep -c OpTypeFloat || true)
echo "opencl: $floats float types"
[ "$floats" -eq 0 ]
