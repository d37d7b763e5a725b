#!/bin/sh
# SPDX-License-Identifier: MIT
# Broken on purpose: fetches from an address.
fetch https://planted.invalid/file
