#!/bin/bash
# SPDX-License-Identifier: MIT
# Figures of the presets against tests/accuracy.csv: on scenes drawn here, and on the
# benchmark's scene where ../shared/data holds it.
#   usage: accuracy.sh [BUILD]
set -eu
cd "$(dirname "$0")/../.."
build=${1:-build}
[ -d "$build/meson-private" ] || meson setup "$build" >/dev/null
ninja -C "$build" tests/bench_accuracy >/dev/null
data=../shared/data
[ -d $data ] || echo "accuracy: no $data: drawn scenes alone"
"$build/tests/bench_accuracy" --check tests/accuracy.csv $data
