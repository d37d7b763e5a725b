#!/bin/sh
# SPDX-License-Identifier: MIT
# Kernel, video driver and busybox of an arm64 Debian for tests/port/v4l2_guest.py, by the
# package manager, without adding an architecture to this system.  Unpacked they take 40 MB
# in ~/.cache/plenofix/guest.
set -eu
keep=${XDG_CACHE_HOME:-$HOME/.cache}/plenofix/guest
[ ! -s "$keep/busybox" ] || {
    echo "guest: is there already: $keep"
    exit 0
}
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
chmod 755 "$tmp"
mkdir -p "$tmp/state/lists/partial" "$tmp/cache/archives/partial"
cd "$tmp"
foreign="-o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State=$tmp/state
    -o Dir::Cache=$tmp/cache -o Dir::State::status=/dev/null -o APT::Sandbox::User="
# shellcheck disable=SC2086
{
    apt-get $foreign -q update
    apt-get $foreign -q download linux-image-arm64 busybox-static
    apt-get $foreign -q download "$(dpkg-deb -f linux-image-arm64_*.deb Depends | sed 's/ .*//')"
} >log 2>&1 || {
    tail -n 3 log >&2
    echo "guest: cannot fetch the packages" >&2
    exit 1
}
dpkg-deb -x "$(ls -S linux-image-*.deb | head -n 1)" kernel
dpkg-deb -x busybox-static*.deb box
mkdir -p "$keep/mod"
cp kernel/boot/vmlinuz-* "$keep/vmlinuz"
for m in mc videodev videobuf2-common videobuf2-v4l2 rc-core cec v4l2-dv-timings v4l2-tpg \
    videobuf2-memops videobuf2-dma-contig videobuf2-vmalloc vivid; do
    cp "$(find kernel/lib -name "$m.ko")" "$keep/mod/"
done
cp box/bin/busybox "$keep/busybox"
echo "guest: fetched into $keep"
