#!/bin/sh
# SPDX-License-Identifier: MIT
# Builds stream_m7.elf for QEMU's mps2-an500 (Cortex-M7).  usage: build.sh [FOLDER]
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-.}
arm-none-eabi-gcc -mcpu=cortex-m7 -mthumb -mfloat-abi=hard --specs=picolibc.specs \
    -std=gnu99 -O2 -ffunction-sections -fdata-sections -Wall -Wextra -Werror \
    -I"$top/include" -I"$top/port" "$top"/examples/stream_m7/main.c \
    "$top"/port/semihost/semihost.c "$top"/src/*.c -o "$out/stream_m7.elf" \
    --crt0=semihost --oslib=semihost -Wl,--gc-sections \
    -Wl,--defsym=__flash=0 -Wl,--defsym=__flash_size=4M \
    -Wl,--defsym=__ram=0x20000000 -Wl,--defsym=__ram_size=4M
arm-none-eabi-size "$out/stream_m7.elf"
