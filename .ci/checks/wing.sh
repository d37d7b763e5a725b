#!/bin/bash
# SPDX-License-Identifier: MIT
# The example's quick flight, judged by its own report, and its packets read by PyPI's
# spacepackets where that is installed.
#   usage: wing.sh [BUILD]
set -eu
cd "$(dirname "$0")/../.."
build=${1:-build}
[ -d "$build/meson-private" ] || meson setup "$build" >/dev/null
ninja -C "$build" tools/plenofix >/dev/null
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
examples/wing_monitor/run --quick "$build/tools/plenofix" "$out"
for packets in host thin; do
    got=0
    python3 tests/bench/spacepackets_check.py "$out/$packets.bin" || got=$?
    [ $got = 0 ] || [ $got = 77 ] || exit 1
done
