#!/bin/sh
# SPDX-License-Identifier: MIT
# plenofix bench: one round of every case, as text and as JSON; every option, wrong usage.
set -eu
plenofix=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

fail()
{
    echo "$1"
    exit 1
}

# wrong ARGUMENTS: exit status 2, one line on stderr, nothing on stdout.
wrong()
{
    status=0
    "$plenofix" bench "$@" >"$folder/out" 2>"$folder/error" || status=$?
    [ "$status" = 2 ] || fail "bench $*: exit status $status, not 2"
    [ "$(wc -l <"$folder/error")" = 1 ] || fail "bench $*: not one line of error"
    [ ! -s "$folder/out" ] || fail "bench $*: output beside an error"
}

"$plenofix" bench --list >"$folder/names"
[ "$(wc -l <"$folder/names")" -ge 15 ] || fail "few names"
"$plenofix" bench --rounds 1 >"$folder/text"
"$plenofix" bench --rounds 1 --json >"$folder/json"
while read -r name; do
    grep -q "^$name  *[0-9.]* *[0-9.]* *[0-9.]*\$" "$folder/text" || fail "text lacks $name"
    grep -q "\"$name\"" "$folder/json" || fail "JSON lacks $name"
done <"$folder/names"
[ "$(wc -l <"$folder/text")" = $(($(wc -l <"$folder/names") + 1)) ] || fail "other lines"
python3 - "$folder/json" <<'CHECK'
import json
import sys
for row in json.load(open(sys.argv[1], encoding='utf-8')):
    assert row['ms'] > 0 and row['ns_per_cell'] > 0 and row['bytes'] >= 0, row
CHECK

only="gradient 289x193 5 views 9x9"
"$plenofix" bench --rounds 1 --only "$only" >"$folder/one"
[ "$(wc -l <"$folder/one")" = 2 ] || fail "--only gives more than one case"
"$plenofix" bench --list --only "$only" | grep -qx "$only" || fail "--list --only"

# Instructions, where valgrind is; one clear line where it is not.
if command -v valgrind >/dev/null; then
    "$plenofix" bench --rounds 1 --only "$only" --instructions >"$folder/count"
    grep -q "ins/cell" "$folder/count" || fail "no column of instructions"
    awk 'NR == 2 && !($(NF - 1) > 50 && $(NF - 1) < 5000) { exit 1 }' "$folder/count" ||
        fail "instructions: $(tail -n 1 "$folder/count")"
    "$plenofix" bench --rounds 1 --only "$only" --instructions --json |
        grep -q instructions_per_cell || fail "JSON lacks instructions"
fi
status=0
PATH= "$plenofix" bench --only "$only" --instructions >/dev/null 2>"$folder/error" || status=$?
[ "$status" = 1 ] || fail "without valgrind: exit status $status, not 1"
grep -q valgrind "$folder/error" || fail "the error does not name valgrind"

wrong --rounds 0
wrong --rounds 1001
wrong --rounds five
wrong --rounds
wrong --only SAD
wrong --only ""
wrong --only
wrong --instruction
wrong 5
"$plenofix" bench --help | grep -q -e --instructions || fail "--help lacks an option"
