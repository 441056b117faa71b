"""LAS and LAZ files that are damaged, each with what is said of it."""

from __future__ import annotations

import struct

import numpy as np

from formats.las_files import GOOD, LAZ, OLD, changed

(POINTS_AT,) = struct.unpack_from("<I", GOOD, 96)
(PACKED_AT,) = struct.unpack_from("<I", LAZ, 96)
(CHUNKS_AT,) = struct.unpack_from("<q", LAZ, PACKED_AT)

BAD = {
    "something else": (b"ply\n", "not a LAS file: it does not begin with 'LASF'"),
    "nothing": (b"", "not a LAS file"),
    "four bytes": (b"LASF", "not all of the LAS header is there; get the whole file again"),
    "cut in the header": (GOOD[:300], "not all of the LAS header is there"),
    "cut in the records": (GOOD[: POINTS_AT - 1], "not all of the LAS header is there"),
    "cut in the points": (
        OLD[:-1],
        "its header promises 40 points, which take 1360 bytes, but 1359 bytes follow; get the",
    ),
    "cut in the last record": (GOOD[:-1], "not all of the LAS records is there"),
    "version 1.9": (
        changed(GOOD, 25, "B", 9),
        r"LAS version 1\.9, which is not known; export it as LAS 1\.5 or earlier",
    ),
    "version 2.0": (changed(GOOD, 24, "BB", 2, 0), r"LAS version 2\.0, which is not known"),
    "format 11": (
        changed(GOOD, 104, "B", 11),
        "its point format 11 is not known; export it in point format 0 to 3 or 6 to 8",
    ),
    "waves": (changed(GOOD, 104, "B", 9), "its point format 9 has waves, which are not known"),
    "endless": (
        changed(GOOD, 247, "<Q", 10**12),
        "its header promises 1000000000000 points, which take",
    ),
    "endless, old": (changed(OLD, 107, "<I", 2**32 - 1), "promises 4294967295 points"),
    "endless records": (changed(GOOD, 100, "<I", 2**32 - 1), "not all of the LAS records is there"),
    "endless last records": (changed(GOOD, 243, "<I", 2**32 - 1), "not all of the LAS records"),
    "last records beyond the end": (changed(GOOD, 235, "<Q", 2**60), "not all of the LAS records"),
    "scale of 0": (changed(OLD, 131, "<d", 0.0), r"its scales are \[0\.0, .*, which are no steps"),
    "scale of NaN": (changed(OLD, 139, "<d", np.nan), r"its scales are \[0\.01, nan, 0\.002\]"),
    "offset of infinity": (changed(OLD, 155, "<d", np.inf), "which are no steps"),
    "scale of all": (changed(OLD, 131, "<d", 1e308), "by which its points are not finite"),
    "points too short": (
        changed(GOOD, 105, "<H", 40),
        "cannot be read as LAS .the 4 extra bytes of a point are not as described.",
    ),
    "points shorter than their format": (
        changed(OLD, 105, "<H", 20),
        "Incoherent point size, header says 20 point_format created says 34",
    ),
    "unknown extra type": (
        GOOD.replace(b"\0\0\x01\x06extra u1", b"\0\0\x63\x06extra u1"),
        "cannot be read as LAS .UnknownExtraType 99.",
    ),
    "an extra dimension of nothing": (
        GOOD.replace(b"\0\0\x01\x06extra u1", b"\0\0\0\0extra u1"),
        r"the \d+ extra bytes of a point are not as described",
    ),
    "no word on compression": (
        changed(GOOD, 104, "B", 0x87),
        "compressed points cannot be read .it does not say how they are compressed.",
    ),
    "LAZ cut in the points": (LAZ[: PACKED_AT + 200], "not all of the LAS records is there"),
    "LAZ without its list": (
        changed(LAZ[: PACKED_AT + 200], 243, "<I", 0),
        "its 40 compressed points cannot be read .the list of their chunks is damaged.",
    ),
    "LAZ without points": (
        changed(LAZ[:PACKED_AT], 243, "<I", 0),
        "the list of their chunks is damaged",
    ),
    "LAZ of endless chunks": (
        changed(LAZ, CHUNKS_AT + 4, "<I", 2**32 - 1),
        "the list of their chunks is damaged",
    ),
    "LAZ with its list nowhere": (
        changed(LAZ, PACKED_AT, "<q", 10),
        "the list of their chunks is damaged",
    ),
    "LAZ endless": (
        changed(LAZ, 247, "<Q", 10**12),
        "its 1000000000000 compressed points cannot be read .their chunks hold fewer.",
    ),
    "LAZ with an endless layer": (
        changed(LAZ, PACKED_AT + 8 + struct.unpack_from("<H", LAZ, 105)[0] + 4, "<I", 2**32 - 1),
        "a chunk is shorter than its layers",
    ),
    "LAZ of longer points": (
        changed(LAZ, 105, "<H", struct.unpack_from("<H", LAZ, 105)[0] + 1),
        r"points of \d+ bytes are packed as \d+",
    ),
    "LAZ of other packing": (
        changed(LAZ, LAZ.index(b"laszip encoded") + 52, "<H", 1),
        "compressed points cannot be read .they are packed in an unknown way.",
    ),
    "LAZ of an item of another size": (
        changed(LAZ, LAZ.index(b"laszip encoded") + 52 + 34, "<H", 11),
        "compressed points cannot be read .they are packed in an unknown way.",
    ),
    "LAZ of unknown packing": (
        changed(LAZ, LAZ.index(b"laszip encoded") + 52, "<H", 99),
        "compressed points cannot be read",
    ),
}
