#!/bin/sh
# SPDX-License-Identifier: MIT
# plenofix devices lists the core always; refuses what it does not know.
set -eu
"$1" devices | grep -q '^cpu '
"$1" devices --help | grep -q 'depth --device'
status=0
"$1" devices surplus 2>/dev/null || status=$?
[ $status -eq 2 ]
# No driver: the list ends with what to do, not with an error.
OCL_ICD_VENDORS=/nonexistent "$1" devices | grep -q 'install'
