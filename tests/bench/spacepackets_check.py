# SPDX-License-Identifier: MIT
"""The packets of monitor, read by PyPI's spacepackets.  usage: spacepackets_check.py P.bin
Skips (exit status 77) when the package is missing."""
import pathlib
import sys

try:
    from spacepackets.ccsds import SpacePacketHeader
except ImportError:
    print('skipped: spacepackets is not installed (pip install spacepackets)')
    sys.exit(77)


def crc16(data):
    crc = 0xffff
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ (0x1021 if crc & 0x8000 else 0)) & 0xffff
    return crc


data = pathlib.Path(sys.argv[1]).read_bytes()
at = count = 0
last = None
while at < len(data):
    head = SpacePacketHeader.unpack(data[at:at + 6])
    whole = head.data_len + 7
    packet = data[at:at + whole]
    if len(packet) != whole or crc16(packet) != 0:
        sys.exit(f'packet {count}: cut short or damaged')
    if head.apid != 100 or not head.sec_header_flag:
        sys.exit(f'packet {count}: apid {head.apid}')
    if last is not None and head.seq_count != (last + 1) % 16384:
        sys.exit(f'packet {count}: sequence {head.seq_count} after {last}')
    last = head.seq_count
    at += whole
    count += 1
print(f'{count} packets, as spacepackets reads them')
sys.exit(count == 0)
