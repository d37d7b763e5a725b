#!/bin/sh
# SPDX-License-Identifier: MIT
# The core and its goldens on a bare LEON3 (SPARC V8, big-endian), emulated.
# QEMU's status says nothing here: the verdict is read from the serial port.
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
here=$top/tests/target/leon3
sparc64-linux-gnu-gcc -std=c99 -O2 -m32 -mcpu=leon3 -mflat -msoft-float -ffreestanding -fno-tree-loop-distribute-patterns \
    -fno-pic -no-pie -static -nostdlib -Wall -Wextra -Werror \
    -I"$top/include" -I"$top/src" -I"$top/tests" -Wl,-T,"$here/link.ld" \
    -Wl,--build-id=none "$here/start.S" "$here/main.c" "$here/arith.c" "$top"/tests/golden/*.c \
    "$top"/src/*.c -o "$folder/selftest.elf"
timeout 100 qemu-system-sparc -M leon3_generic -display none -monitor none \
    -serial stdio -kernel "$folder/selftest.elf" </dev/null | tee "$folder/log"
grep -q '^leon3: all equal' "$folder/log"
