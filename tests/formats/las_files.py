"""LAS and LAZ files made by laspy, for the tests."""

from __future__ import annotations

import io
import struct
from typing import Any

import laspy
import numpy as np
import numpy.typing as npt
from laspy.vlrs.vlrlist import VLRList

N = 40

#: Versions, and point formats that each may have.
KINDS = [
    ("1.1", 0),
    ("1.2", 0),
    ("1.2", 1),
    ("1.2", 2),
    ("1.2", 3),
    ("1.3", 3),
    ("1.4", 1),
    ("1.4", 6),
    ("1.4", 7),
    ("1.4", 8),
    ("1.5", 7),
]

EXTRA_TYPES = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8")


def random_las(version: str, point_format: int, n: int = N, *, extras: bool = True) -> Any:
    """Every dimension with every bit random, records, and extra dimensions of every kind."""
    rng = np.random.default_rng(point_format)
    header = laspy.LasHeader(version=version, point_format=point_format)
    header.scales = np.array([0.01, 0.001, 0.002])
    header.offsets = np.array([500_000.0, 4_000_000.0, -10.0])
    header.system_identifier = "scanner"
    header.file_source_id = 7
    if extras:
        header.add_extra_dims(
            [laspy.ExtraBytesParams(f"extra {code}", code) for code in EXTRA_TYPES]
            + [
                laspy.ExtraBytesParams("pair", "2i2"),
                laspy.ExtraBytesParams("triple", "3f4"),
                laspy.ExtraBytesParams("blob", "6u1"),
                laspy.ExtraBytesParams(
                    "amplitude", "i2", "scaled", offsets=np.array([5.0]), scales=np.array([0.01])
                ),
                laspy.ExtraBytesParams(
                    "both", "2u1", offsets=np.array([0.0, 1.0]), scales=np.array([0.5, 0.1])
                ),
            ]
        )
    header.vlrs.append(laspy.VLR("by hand", 99, "x" * 31, rng.bytes(100)))
    header.vlrs.append(laspy.VLR("LASF_Projection", 2112, "WKT", b'PROJCS["none"]\0'))
    las = laspy.LasData(header, laspy.ScaleAwarePointRecord.zeros(n, header=header))
    raw = rng.bytes(las.points.array.nbytes)
    las.points.array[:] = np.frombuffer(raw, las.points.array.dtype)
    for name in las.points.array.dtype.names:
        values = las.points.array[name]
        if values.dtype.base.kind == "f":
            las.points.array[name] = rng.normal(size=values.shape)
    if version >= "1.4":
        far = laspy.VLR("far away", 5, "last", rng.bytes(70_000))
        las.evlrs = VLRList([far])
    return las


def saved(las: Any, *, packed: bool = False) -> bytes:
    """Bytes of a file."""
    stream = io.BytesIO()
    las.write(stream, do_compress=packed)
    return stream.getvalue()


GOOD = saved(random_las("1.4", 7))
OLD = saved(random_las("1.2", 3, extras=False))
LAZ = saved(random_las("1.4", 7), packed=True)


def changed(data: bytes, at: int, form: str, *values: Any) -> bytes:
    """Pack other values into a file, at one place."""
    copy = bytearray(data)
    struct.pack_into(form, copy, at, *values)
    return bytes(copy)


def opaque_las(n_bytes: int, name: bytes = b"blob") -> tuple[bytes, bytes]:
    """A file whose points have bytes of no type; these bytes, and how they are described."""
    las = random_las("1.4", 6, extras=False)
    las.add_extra_dims(
        [
            laspy.ExtraBytesParams("before", "i2"),
            laspy.ExtraBytesParams("q" * len(name), np.dtype((np.uint8, (n_bytes,)))),
            laspy.ExtraBytesParams("after", "f4"),
        ]
    )
    blob = np.random.default_rng(n_bytes).integers(0, 256, (N, n_bytes), np.uint8)
    las.points.array["q" * len(name)] = blob
    las["after"] = np.arange(N)
    data = saved(las)
    described = b"\0\0\0" + bytes([n_bytes]) + name
    start = data.index(b"q" * len(name)) - 4
    return data[:start] + described + data[start + len(described) :], described


def opened(data: bytes) -> Any:
    """Open a file by laspy."""
    return laspy.read(io.BytesIO(data))


def dimension(las: Any, name: str) -> npt.NDArray[Any]:
    """Values of a dimension as plain numbers."""
    return np.array(las[name])


def facts(data: bytes) -> dict[str, Any]:
    """What of a file matters: all but the order and wording of its records, and its padding."""
    las = opened(data)
    header = las.header
    names = (
        "version", "file_source_id", "uuid", "system_identifier", "generating_software",
        "creation_date", "extra_header_bytes", "extra_vlr_bytes",
    )  # fmt: skip
    arrays = ("scales", "offsets", "mins", "maxs", "number_of_points_by_return")
    extras = [
        (
            bytes(extra.name), bytes(extra.description), extra.data_type, *(
                None if values is None else list(values)
                for values in (extra.scale, extra.offset, extra.no_data)
            ),
        )
        for record in las.vlrs.get("ExtraBytesVlr")
        for extra in record.extra_bytes_structs
    ]  # fmt: skip
    return {
        **{name: getattr(header, name) for name in names},
        **{name: np.asarray(getattr(header, name)).tolist() for name in arrays},
        "encoding": header.global_encoding.value,
        "format": las.point_format.id,
        "points": las.points.array.tobytes(),
        "extras": extras,
        **{
            kind: sorted(
                (record.user_id, record.record_id, record.description, record.record_data_bytes())
                for record in records or []
                if record.record_id not in (4, 22204)
            )
            for kind, records in (("records", las.vlrs), ("extended", las.evlrs))
        },
    }
