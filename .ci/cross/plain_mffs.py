# SPDX-License-Identifier: MIT
"""Copy a 32-bit PowerPC library and turn mffsce, mffscdrn, mffscrn, mffscrni and mffsl
into mffs, as processors before ISA 3.0 read them.  usage: plain_mffs.py IN OUT"""
import struct
import sys

VARIANTS = {1, 20, 21, 22, 23, 24}  # the field that a plain mffs leaves 0

data = bytearray(open(sys.argv[1], 'rb').read())
changed = 0
for at in range(0, len(data) - 3, 4):
    word, = struct.unpack_from('>I', data, at)
    if word & 0xfc0007fe == 0xfc00048e and (word >> 16) & 31 in VARIANTS:
        struct.pack_into('>I', data, at, word & 0xffe007ff)
        changed += 1
open(sys.argv[2], 'wb').write(data)
print(f'{changed} instructions', file=sys.stderr)
