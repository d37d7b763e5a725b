#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs into a scratch folder, uses what is there as users do, uninstalls, and looks
# for leftovers.
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$work/usr

say()
{
    echo "install: $*"
}

meson setup "$work/build" "$top" --prefix "$prefix" --libdir lib -Dtests=disabled \
    -Dopencl=disabled >"$work/log" || { cat "$work/log"; exit 1; }
ninja -C "$work/build" >"$work/log" || { cat "$work/log"; exit 1; }
meson install -C "$work/build" --no-rebuild --quiet

for f in include/plenofix/plenofix.h lib/libplenofix.a lib/libplenofix.so \
    lib/pkgconfig/plenofix.pc bin/plenofix share/man/man1/plenofix.1; do
    [ -e "$prefix/$f" ] || { say "not installed: $f"; exit 1; }
done
# cl.h goes with the OpenCL library, which this build leaves out
for h in "$top"/include/plenofix/*.h; do
    [ "${h##*/}" = cl.h ] || [ -e "$prefix/include/plenofix/${h##*/}" ] || {
        say "not installed: ${h##*/}; is it in include/meson.build?"
        exit 1
    }
done
say "files are in place"

"$prefix/bin/plenofix" --version
"$prefix/bin/plenofix" help | sed -n 's/^  \([a-z][a-z-]*\)  .*/\1/p' |
    while read -r name; do
        grep -q "^\.SS $(echo "$name" | sed 's/-/\\\\-/g')\$" \
            "$prefix/share/man/man1/plenofix.1" || {
            say "command $name is not in the manual page"
            exit 1
        }
    done
if command -v man >/dev/null; then
    warnings=$(MANWIDTH=200 man -l --warnings=w "$prefix/share/man/man1/plenofix.1" 2>&1 >/dev/null)
    [ -z "$warnings" ] || { say "manual page: $warnings"; exit 1; }
fi
say "manual page names every command"

export PKG_CONFIG_PATH="$prefix/lib/pkgconfig" LD_LIBRARY_PATH="$prefix/lib"
"$top/examples/consumers/pkg-config/build.sh" "$work/shared"
"$work/shared"
"$top/examples/consumers/pkg-config/build.sh" "$work/static" --static
"$work/static"
unset PKG_CONFIG_PATH LD_LIBRARY_PATH
say "usable by pkg-config"

cp -r "$top/examples/consumers" "$work/consumers"
mkdir "$work/consumers/subproject/subprojects"
ln -s "$top" "$work/consumers/subproject/subprojects/plenofix"
meson setup "$work/sub" "$work/consumers/subproject" -Dplenofix:tools=disabled \
    -Dplenofix:tests=disabled -Dplenofix:opencl=disabled >"$work/log" ||
    { cat "$work/log"; exit 1; }
ninja -C "$work/sub" >"$work/log" || { cat "$work/log"; exit 1; }
"$work/sub/consumer"
say "usable as a subproject"

ninja -C "$work/build" uninstall >"$work/log"
left=$([ ! -d "$prefix" ] || find "$prefix" ! -type d)
[ -z "$left" ] || { say "left behind: $left"; exit 1; }
say "uninstalled without leftovers"
