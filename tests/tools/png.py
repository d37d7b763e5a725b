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


def samples(path):
    """All samples of an 8-bit grey file."""
    data = open(path, "rb").read()
    w, h = struct.unpack(">II", data[16:24])
    at, packed = 8, b""
    while at < len(data):
        n = struct.unpack(">I", data[at:at + 4])[0]
        if data[at + 4:at + 8] == b"IDAT":
            packed += data[at + 8:at + 8 + n]
        at += 12 + n
    raw, out, above = zlib.decompress(packed), [], [0] * w
    for y in range(h):
        kind, row = raw[y * (w + 1)], list(raw[y * (w + 1) + 1:(y + 1) * (w + 1)])
        for x in range(w):
            left = row[x - 1] if x else 0
            corner = above[x - 1] if x else 0
            p = left + above[x] - corner
            near = min((left, above[x], corner), key=lambda v: abs(p - v))
            row[x] = (row[x] + (0, left, above[x], (left + above[x]) // 2, near)[kind]) % 256
        out += row
        above = row
    return out
