"""What protects E57 files from being looked into when they are damaged: checksums and places.

Every 1024 bytes end in a CRC-32C of the others; the header says where the XML is, and how long.
"""

import struct

_PAGE = 1024
_SUM = 4
_CONTENTS = _PAGE - _SUM
_POLYNOMIAL = 0x82F63B78

_PLACES_AT = 16
_PLACES = struct.Struct("<QQQ")


def _entry(byte: int) -> int:
    for _ in range(8):
        byte = byte >> 1 ^ (_POLYNOMIAL if byte & 1 else 0)
    return byte


_TABLE = [_entry(byte) for byte in range(256)]


def unsealed(data: bytes) -> bytes:
    """Return the contents of all pages."""
    starts = range(0, len(data), _PAGE)
    return b"".join(data[start : start + _CONTENTS] for start in starts)


def sealed(contents: bytes) -> bytes:
    """Make pages of contents, and a header that says where the XML in them is."""
    start, end = contents.find(b"<?xml"), len(contents.rstrip(b"\0"))
    if start >= _PLACES_AT + _PLACES.size:
        n_pages = -(-len(contents) // _CONTENTS)
        place = start // _CONTENTS * _PAGE + start % _CONTENTS
        places = _PLACES.pack(n_pages * _PAGE, place, end - start)
        contents = contents[:_PLACES_AT] + places + contents[_PLACES_AT + _PLACES.size :]
    pages = (
        contents[start : start + _CONTENTS].ljust(_CONTENTS, b"\0")
        for start in range(0, len(contents), _CONTENTS)
    )
    return b"".join(page + _checksum(page) for page in pages)


def _checksum(page: bytes) -> bytes:
    crc = 0xFFFFFFFF
    for byte in page:
        crc = _TABLE[crc & 0xFF ^ byte] ^ crc >> 8
    return (crc ^ 0xFFFFFFFF).to_bytes(_SUM, "big")
