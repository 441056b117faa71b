"""Well-formed LAS, LAZ, PCD and E57 files, as a start for damaged ones."""

import struct
import tempfile
from collections.abc import Iterator
from pathlib import Path

import helpers_path  # noqa: F401
import laspy
import numpy as np

from formats.e57_files import Scan, save_e57
from formats.las_files import KINDS, opaque_las, random_las, saved
from formats.test_pcd import ENCODINGS, pcd, rich, xyz

_N = 5


def las_files(packed: bool) -> Iterator[bytes]:
    """LAS or LAZ files of every version and point format."""
    for version, point_format in KINDS:
        for extras in (False, True):
            las = random_las(version, point_format, _N, extras=extras)
            if version >= "1.4":
                las.evlrs[0] = laspy.VLR("far away", 5, "last", bytes(9))
            yield saved(las, packed=packed)
    las = random_las("1.4", 6, 0, extras=False)
    las.evlrs.clear()
    yield saved(las, packed=packed)
    if not packed:
        yield opaque_las(8)[0]
        return
    data = saved(random_las("1.2", 3, _N), packed=True)
    (start,) = struct.unpack_from("<I", data, 96)
    (listed,) = struct.unpack_from("<q", data, start)
    streamed = struct.pack("<q", -1) + data[start + 8 :] + struct.pack("<q", listed)
    yield data[:start] + streamed


def pcd_files() -> Iterator[bytes]:
    """PCD files of every encoding."""
    for encoding in ENCODINGS:
        yield pcd(xyz(), encoding)
        yield pcd(xyz(4, "f8"), encoding, (2, 2), "1 2 3 1 0 0 0", ("by hand", "unit metre"))
        yield pcd(rich(), encoding)
        colors = np.arange(3, dtype="u4")
        yield pcd([*xyz(3), ("rgb", colors.view("f4")), ("_", colors)], encoding)
        yield pcd([*xyz(3), ("rgba", colors), ("normal_x", colors.astype("f4"))], encoding)
        yield pcd(xyz(0), encoding)
    yield pcd(xyz(), "ascii").replace(b"\n", b"\r\n")
    yield pcd(xyz(3)[:2], "ascii", head="VERSION .7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 3\n"
              "DATA ascii\n")  # fmt: skip


def ptx_files() -> Iterator[bytes]:
    """PTX files with scans of every kind."""
    points = ((0, 0, 0), (1.5, -2, 3), (1e-3, 4, 5e2), (7, 8, 9))
    places = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    still = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    turned = "0 1 0 0\n-1 0 0 0\n0 0 2 0\n100.5 -20 3 1\n"
    scans = [
        f"{columns}\n{4 // columns}\n{places}{matrix}"
        + "".join(f"{' '.join(map(str, point))}{more}\n" for point in points)
        for columns, matrix in ((2, still), (4, turned))
        for more in ("", " 0.5", " 1 2 255", " 0.25 0 0 7")
    ]
    for scan in scans:
        yield scan.encode()
    yield "".join(scans).encode()
    yield f"0\n7\n{places}{still}{scans[-1]}".replace("\n", "\r\n").encode()
    yield b""


def e57_files() -> Iterator[bytes]:
    """E57 files with scans of every kind."""
    rng = np.random.default_rng(0)
    axes = [f"cartesian{axis}" for axis in "XYZ"]
    single = {name: rng.normal(size=_N).astype("f4") for name in axes}
    double = {name: rng.normal(size=_N) for name in axes}
    rounded = {name: np.round(values, 2) for name, values in double.items()}
    ball = {f"spherical{name}": rng.random(_N) for name in ("Range", "Azimuth", "Elevation")}
    more = {
        "cartesianInvalidState": np.arange(_N, dtype="u1") % 2,
        "intensity": rng.random(_N).astype("f4"),
        **{f"color{name}": np.arange(_N, dtype="u1") for name in ("Red", "Green", "Blue")},
        "rowIndex": np.arange(_N, dtype="u2"),
        "returnCount": np.arange(_N, dtype="i4"),
    }
    for scans in (
        (Scan(double),),
        (Scan(rounded, steps=dict.fromkeys(axes, 0.01), name="front door"),),
        (Scan({**single, **more}, (0.5, 0.5, 0.5, 0.5), (1.0, 2.0, 3.0)), Scan(ball)),
        (Scan({name: values[:0] for name, values in double.items()}),),
        (),
    ):
        with tempfile.TemporaryDirectory() as folder:
            yield save_e57(Path(folder) / "a.e57", *scans, metadata="none").read_bytes()
