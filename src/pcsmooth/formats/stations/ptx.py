"""PTX, of Leica's scanners: every scan of a file in one cloud, reading only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import is_number, is_whole, parsed
from pcsmooth.formats.stations.scans import Scan, cloud_of_scans
from pcsmooth.formats.typed_rows import read_rows
from pcsmooth.positions import LARGEST

#: Numbers on each line before the points: columns, rows, place and axes of the scanner, matrix.
_HEADER_WIDTHS = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
_FIRST_ROW_OF_MATRIX = 6
_MOST_HEADER_BYTES = 1 << 12

#: What follows the coordinates of a point, by the number of its values.
_NAMES: dict[int, tuple[str, ...]] = {
    3: (),
    4: ("intensity",),
    6: COLORS,
    7: ("intensity", *COLORS),
}


class _Header(NamedTuple):
    """What stands before the points of a scan: their number, the scanner's place, the matrix."""

    columns: int
    rows: int
    place: str
    matrix: npt.NDArray[np.float64]


def is_ptx(head: bytes) -> bool:
    """Whether a file that begins with these bytes has the header of a PTX file."""
    try:
        _header_of(_lines(head[:_MOST_HEADER_BYTES]))
    except ValueError:
        return False
    return True


def read_ptx(data: bytes, path: str, dim: int | None) -> PointCloud:
    """Read a PTX file.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors.
    dim : {2, 3} or None
        Number of coordinates; with 2 the third is a column.

    Returns
    -------
    PointCloud
        The points of every scan, one scan after the other, moved by its matrix; those at 0 0 0 in
        the system of the scanner, which it has not measured, are NaN. The column ``scan`` counts
        scans from 0; intensity and colors are columns if there are any.

    Raises
    ------
    CloudFileError
        Not PTX, cut short, a value that is no number, or a matrix that is no affine map.
    """
    lines = _lines(data)
    scans: list[Scan] = []
    comments: list[str] = []
    first = 0
    try:
        while first < len(lines) or not scans:
            start = first + len(_HEADER_WIDTHS)
            header = _header_of(lines[first:start])
            first = start + header.columns * header.rows
            scans.append(_scan(lines[start:first], header))
            comments.append(
                f"scan {len(comments)}: {header.columns} columns of {header.rows} points, "
                f"scanner at {header.place}"
            )
    except ValueError as error:
        raise CloudFileError(
            path,
            f"scan {len(scans)}: {excerpt(str(error))}",
            "get the whole file again, or export it again",
        ) from error
    return cloud_of_scans(scans, dim, comments)


def _lines(data: bytes) -> list[bytes]:
    return [line for line in data.removeprefix(b"\xef\xbb\xbf").splitlines() if line.strip()]


def _header_of(lines: Sequence[bytes]) -> _Header:
    """Read the header that lines begin with; `ValueError` if there is none."""
    if len(lines) < len(_HEADER_WIDTHS):
        raise ValueError(f"its header has {len(lines)} lines of {len(_HEADER_WIDTHS)}")
    head = [line.decode("latin-1").split() for line in lines[: len(_HEADER_WIDTHS)]]
    for number, (words, width) in enumerate(zip(head, _HEADER_WIDTHS, strict=True), 1):
        is_right = len(words) == width and all(map(is_number, words))
        if not is_right or (width == 1 and not is_whole(words[0])):
            wanted = "a whole number" if width == 1 else f"{width} numbers"
            shown = excerpt(" ".join(words))
            raise ValueError(f"line {number} of its header is '{shown}', not {wanted}")
    numbers = parsed([word for words in head[_FIRST_ROW_OF_MATRIX:] for word in words])
    matrix = numbers.reshape(4, 4)
    if not (np.abs(matrix) <= LARGEST).all() or matrix[:, 3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise ValueError(f"its matrix {matrix.tolist()} is no affine map")
    if np.linalg.matrix_rank(matrix[:3, :3]) < 3:
        raise ValueError(f"its matrix {matrix.tolist()} is singular")
    return _Header(int(head[0][0]), int(head[1][0]), excerpt(" ".join(head[2])), matrix)


def _scan(rows: Sequence[bytes], header: _Header) -> Scan:
    """Read the points of a scan."""
    n_points = header.columns * header.rows
    if len(rows) < n_points:
        raise ValueError(
            f"it promises {n_points} points ({header.columns} columns of {header.rows}), but "
            f"{len(rows)} lines follow"
        )
    width = len(rows[0].split()) if rows else len("xyz")
    if width not in _NAMES:
        raise ValueError(
            f"a point has {width} values, '{rows[0].decode('latin-1').strip()}', not 3, 4, 6 or 7"
        )
    names = ("x", "y", "z", *_NAMES[width])
    types = [(name, np.uint8 if name in COLORS else np.float64) for name in names]
    table = read_rows(rows, np.dtype(types), names)
    xyz = np.stack([table[axis] for axis in "xyz"], axis=1)
    xyz[(xyz == 0.0).all(axis=1)] = np.nan
    with np.errstate(over="ignore", invalid="ignore"):
        xyz = xyz @ header.matrix[:3, :3] + header.matrix[3, :3]
    return Scan(xyz, {name: table[name].copy() for name in _NAMES[width]})
