# SPDX-License-Identifier: MIT
"""Small PNG files for the tests of the tools, without any library."""
import struct
import zlib


def chunk(kind, data):
    crc = zlib.crc32(kind + data)
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", crc)


def write(path, w, h, pixel, depth=8, colour=0, extra=b""):
    """colour: 0 grey, 2 RGB, 3 palette, 4 grey and alpha, 6 RGB and alpha.
    pixel(x, y): one sample or a tuple of them."""
    rows = b""
    for y in range(h):
        rows += b"\0"
        for x in range(w):
            v = pixel(x, y)
            for s in v if isinstance(v, tuple) else (v,):
                rows += struct.pack(">B" if depth == 8 else ">H", s)
    head = struct.pack(">IIBBBBB", w, h, depth, colour, 0, 0, 0)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + extra
                  + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
