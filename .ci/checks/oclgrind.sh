#!/bin/sh
# SPDX-License-Identifier: MIT
# The kernels under a second implementation that watches every access: no race, no
# out-of-bounds, no uninitialised read, and still equal to the core.
set -eu
cd "$(dirname "$0")/../.."
command -v oclgrind >/dev/null || { echo "skipped: oclgrind is not installed"; exit 77; }
test=build/tests/test_cl
[ -x $test ] || { echo "skipped: built without OpenCL"; exit 77; }
log=$(mktemp)
trap 'rm -f "$log"' EXIT
oclgrind --build-options "-cl-opt-disable" --data-races --uninitialized --max-wgsize 64 --local-mem-size 16384 --log "$log" \
    $test tiny
if [ -s "$log" ]; then
    head -20 "$log"
    exit 1
fi
echo "oclgrind: nothing to report"
