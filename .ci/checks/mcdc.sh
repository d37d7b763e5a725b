#!/bin/sh
# SPDX-License-Identifier: MIT
# Modified condition/decision coverage of the core by the unit tests: a report in
# build-ci/mcdc/report.txt, its total on the last line.  Needs clang 19.
set -eu
cd "$(dirname "$0")/../.."
folder=build-ci/mcdc
export CC=clang-19
flags="-fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc"
[ -f $folder/build.ninja ] || meson setup $folder -Dbuildtype=debug \
    -Ddefault_library=static -Dtools=disabled -Dopencl=disabled \
    -Dc_args="$flags" -Dc_link_args="-fprofile-instr-generate"
ninja -C $folder
rm -f $folder/*.profraw
LLVM_PROFILE_FILE="$PWD/$folder/%p.profraw" \
    meson test -C $folder --no-rebuild --suite plenofix:unit
llvm-profdata-19 merge -o $folder/all.profdata $folder/*.profraw
objects=
for t in "$folder"/tests/test_*; do
    [ -f "$t" ] && objects="$objects -object $t"
done
# shellcheck disable=SC2086 # a list of options
llvm-cov-19 report --show-mcdc-summary --instr-profile=$folder/all.profdata \
    $objects -ignore-filename-regex='tests/|subprojects/|port/' >$folder/report.txt
grep -E '\.[ch] ' $folder/report.txt | awk '{ print $1, "mcdc", $NF }'
tail -n 1 $folder/report.txt
