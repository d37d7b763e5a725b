#!/bin/sh
# SPDX-License-Identifier: MIT
# A program that uses the installed library.  usage: build.sh OUTPUT [--static]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
# shellcheck disable=SC2046,SC2086 # lists of options
cc -std=c99 -Wall -Werror "$here/../consumer.c" -o "$1" \
    $(pkg-config ${2:-} --cflags --libs plenofix)
