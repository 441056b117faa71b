"""Every format as one line of parameters: how an example of it is made, and what it keeps.

A further format needs one more entry in `KINDS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import numpy.typing as npt

from formats.ply_files import XYZ, ascii_ply, binary
from pcsmooth.formats import WRITTEN_FORMATS

Points = npt.NDArray[np.float64]

#: Numbers that every format can hold, even as float.
POINTS: Points = np.random.default_rng(3).integers(-(2**15), 2**15, (12, 3)) / 1024

#: Enough that files are written in several parts.
MANY_POINTS: Points = np.random.default_rng(4).integers(-(2**15), 2**15, (3000, 3)) / 1024

DOUBLE = 0.0
FLOAT = 16.0 * 2.0**-24  # half the distance of two floats of 2^4 to 2^5

NORMALS = frozenset({"nx", "ny", "nz"})
COLORS = frozenset({"red", "green", "blue"})
COMMENTS, MARKS = "the comments", "the marks of fixed points"


def intensities(count: int) -> npt.NDArray[np.uint8]:
    """What examples have beside their points, where they can."""
    return np.array([37 * row % 251 for row in range(count)], np.uint8)


@dataclass(frozen=True)
class Kind:
    """A format, or one of the encodings that it has.

    Attributes
    ----------
    name : str
        Of the kind.
    format : str
        Of the format.
    example : callable
        A file of such points, not made by the writer.
    keeps : set of str
        What comes back of a cloud that is not from a file: names of columns, `COMMENTS`, `MARKS`.
        None where such a cloud cannot be written.
    dimension : int
        Number of coordinates.
    column : str
        What the intensities of an example are called; empty if it has none.
    height : str
        What the third coordinate is called where an example is read as a plane cloud.
    rounding : float
        How far positions in an example are rounded that have moved, L.
    new_rounding : float
        How far those of a cloud are that is not from a file.
    empty : str
        What is said of a file without a byte; nothing where that is a cloud without points.
    only_finite : bool
        Whether positions must be finite.
    corners : int
        Points that come together.
    in_pieces : bool
        Whether files are read piece by piece, and so written if they are.
    library : str
        What must be installed; empty if nothing more.
    """

    name: str
    format: str
    example: Callable[[Points], bytes]
    keeps: frozenset[str] | None = None
    dimension: int = 3
    column: str = "intensity"
    height: str = "z"
    rounding: float = DOUBLE
    new_rounding: float = DOUBLE
    empty: str = ""
    only_finite: bool = False
    corners: int = 1
    in_pieces: bool = True
    library: str = ""

    @property
    def is_written(self) -> bool:
        return self.format in WRITTEN_FORMATS

    @property
    def points(self) -> Points:
        """Points that an example is made of."""
        return POINTS[:, : self.dimension]

    @property
    def many_points(self) -> Points:
        return MANY_POINTS[:, : self.dimension]

    def __str__(self) -> str:
        return self.name


def _lines(points: Points, delimiter: str = " ", before: str = "", after: bool = True) -> str:
    """Points in text, a line each, with their intensities after them."""
    more = intensities(len(points)).tolist()
    return "".join(
        before + delimiter.join([*map(repr, point), *[str(each)] * after]) + "\n"
        for point, each in zip(points.tolist(), more, strict=True)
    )


def _text(points: Points, head: str, delimiter: str = " ") -> bytes:
    return (head.format(n=len(points)) + _lines(points, delimiter)).encode()


def _ply_text(points: Points) -> bytes:
    data = ascii_ply(f"{XYZ}, uchar intensity", _lines(points))
    return data.replace(b"1.0\n", b"1.0\ncomment by hand\n", 1)


def _ply_binary(points: Points) -> bytes:
    rows = np.zeros(len(points), [("xyz", "<f8", 3), ("intensity", "u1")])
    rows["xyz"], rows["intensity"] = points, intensities(len(points))
    names = "double x, double y, double z, uchar intensity"
    data = binary(len(points), rows.tobytes(), names)
    return data.replace(b"1.0\n", b"1.0\ncomment by hand\n", 1)


def _las(points: Points, packed: bool) -> bytes:
    import laspy

    from formats.las_files import saved

    header = laspy.LasHeader(version="1.2", point_format=1)
    header.scales, header.offsets = np.full(3, 1 / 1024), np.zeros(3)
    las = laspy.LasData(header, laspy.ScaleAwarePointRecord.zeros(len(points), header=header))
    las.X, las.Y, las.Z = np.rint(1024 * points).astype(np.int32).T
    las.intensity = intensities(len(points))
    return saved(las, packed=packed)


def _pcd(points: Points, is_text: bool) -> bytes:
    head = (
        "# .PCD v0.7 - Point Cloud Data file format\n# by hand\nVERSION 0.7\n"
        "FIELDS x y z intensity\nSIZE 4 4 4 1\nTYPE F F F U\nCOUNT 1 1 1 1\n"
        f"WIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\n"
        f"DATA {'ascii' if is_text else 'binary'}\n"
    ).encode()
    if is_text:
        return head + _lines(points).encode()
    rows = np.zeros(len(points), [("xyz", "<f4", 3), ("intensity", "u1")])
    rows["xyz"], rows["intensity"] = points, intensities(len(points))
    return head + rows.tobytes()


def _e57(points: Points) -> bytes:
    from formats.e57_files import Scan, save_e57

    axes = ("cartesianX", "cartesianY", "cartesianZ")
    fields = dict(zip(axes, points.T, strict=True)) | {"intensity": intensities(len(points))}
    with TemporaryDirectory() as folder:
        return save_e57(Path(folder) / "a.e57", Scan(fields)).read_bytes()


def _ptx(points: Points) -> bytes:
    still = "1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    return f"1\n{len(points)}\n0 0 0\n{still}{_lines(points)}".encode()


def _obj(points: Points) -> bytes:
    faces = "f 1 2 3\n" * (len(points) > 2)
    return f"# by hand\n{_lines(points, before='v ', after=False)}{faces}".encode()


def _off(points: Points) -> bytes:
    faces = len(points) // 3
    rows = _lines(points, after=False)
    triangles = "".join(f"3 {3 * face} {3 * face + 1} {3 * face + 2}\n" for face in range(faces))
    return f"OFF\n# by hand\n{len(points)} {faces} 0\n{rows}{triangles}".encode()


def _stl_text(points: Points) -> bytes:
    corners = _lines(points, before="vertex ", after=False).splitlines()
    facets = [
        "\n".join(
            ["facet normal 0 0 1", "outer loop", *corners[row : row + 3], "endloop", "endfacet"]
        )
        for row in range(0, len(points), 3)
    ]
    return "\n".join(["solid facets by hand", *facets, "endsolid", ""]).encode()


def _stl_binary(points: Points) -> bytes:
    facets = np.zeros(len(points) // 3, [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    facets["v"] = points.reshape(-1, 3, 3)
    return b"by hand".ljust(80) + len(facets).to_bytes(4, "little") + facets.tobytes()


_COLUMNS = NORMALS | COLORS | {"k1"}

_LAS = partial(
    Kind, keeps=_COLUMNS | {COMMENTS, MARKS}, rounding=0.5 / 1024, new_rounding=0.5001e-3,
    empty="not a LAS file", only_finite=True,
)  # fmt: skip

KINDS = [
    Kind("ply text", "ply", _ply_text, _COLUMNS | {"near", COMMENTS, MARKS}, rounding=FLOAT,
         empty="the file is empty"),
    Kind("ply binary", "ply", _ply_binary, _COLUMNS | {"near", COMMENTS, MARKS},
         empty="the file is empty"),
    Kind("xyz", "xyz", partial(_text, head="# by hand\n"), NORMALS | {MARKS}, column="column_4",
         height="column_3"),
    Kind("xy", "xy", partial(_text, head=""), frozenset({"nx", "ny", MARKS}), dimension=2,
         column="column_3", height=""),
    Kind("txt", "txt", partial(_text, head="# by hand\n//X Y Z intensity\n"), _COLUMNS | {MARKS}),
    Kind("asc", "asc", partial(_text, head="x;y;z;intensity\n", delimiter=";"), _COLUMNS | {MARKS}),
    Kind("csv", "csv", partial(_text, head="# by hand\nx,y,z,intensity\n", delimiter=","),
         _COLUMNS | {MARKS}),
    Kind("pts", "pts", partial(_text, head="{n}\n"), NORMALS | {MARKS}, column="column_4",
         height="column_3"),
    _LAS("las", "las", partial(_las, packed=False), library="laspy"),
    _LAS("laz", "laz", partial(_las, packed=True), library="lazrs"),
    Kind("pcd text", "pcd", partial(_pcd, is_text=True), _COLUMNS | {COMMENTS, MARKS},
         rounding=FLOAT, empty="not a PCD file"),
    Kind("pcd binary", "pcd", partial(_pcd, is_text=False), _COLUMNS | {COMMENTS, MARKS},
         rounding=FLOAT, empty="not a PCD file"),
    Kind("obj", "obj", _obj, COLORS, column="", in_pieces=False),
    Kind("off", "off", _off, COLORS, column="", empty="not an OFF file", in_pieces=False),
    Kind("stl text", "stl", _stl_text, column="", corners=3, empty="get the whole file",
         in_pieces=False),
    Kind("stl binary", "stl", _stl_binary, column="", corners=3, rounding=FLOAT,
         empty="get the whole file", in_pieces=False),
    Kind("e57", "e57", _e57, empty="not an E57 file", library="pye57"),
    Kind("ptx", "ptx", _ptx, empty="its header has 0 lines"),
]  # fmt: skip
