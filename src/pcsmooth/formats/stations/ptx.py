"""PTX, of Leica's scanners: every scan of a file in one cloud, reading only."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, islice
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import is_number, is_whole, parsed
from pcsmooth.formats.stations.scans import Scan, ScanChunks, ScanPoints, moved
from pcsmooth.formats.typed_rows import read_rows
from pcsmooth.positions import LARGEST

#: Numbers on each line before the points: columns, rows, place and axes of the scanner, matrix.
_HEADER_WIDTHS = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
_FIRST_ROW_OF_MATRIX = 6
_MOST_HEADER_BYTES = 1 << 12

#: Rows that are looked through at a time.
_ROWS_LOOKED_THROUGH = 1 << 16

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


class PtxChunks(ScanChunks):
    """The points of a PTX file, those of each scan moved by its matrix.

    Those at 0 0 0 in the system of the scanner, which it has not measured, are NaN; intensity and
    colors are columns if there are any.

    Parameters
    ----------
    source : ByteSource
        The file.
    dim : {2, 3} or None
        Number of coordinates; with 2 the third is a column.

    Raises
    ------
    CloudFileError
        Not PTX, cut short, or a matrix that is no affine map.
    """

    def __init__(self, source: ByteSource, dim: int | None) -> None:
        lines = _lines_of(source)
        self._headers: list[_Header] = []
        scans: list[Scan] = []
        failure: ValueError | None = None
        try:
            while (head := list(islice(lines, len(_HEADER_WIDTHS)))) or not scans:
                self._headers.append(_header_of(head))
                scans.append(_scan_below(self._headers[-1], lines))
        except ValueError as error:
            failure = error
        comments = [
            f"scan {number}: {header.columns} columns of {header.rows} points, "
            f"scanner at {header.place}"
            for number, header in enumerate(self._headers)
        ]
        super().__init__(source, dim, scans, comments)
        if failure is not None:
            for _ in self.read(_ROWS_LOOKED_THROUGH):
                pass  # what is wrong with the points of a scan before is said first
            raise self._failure(len(scans), failure)

    def _blocks(self, rows: int) -> Iterator[tuple[int, ScanPoints]]:
        lines = _lines_of(self.source)
        for number, (header, scan) in enumerate(zip(self._headers, self._scans, strict=False)):
            next(islice(lines, len(_HEADER_WIDTHS) - 1, None), None)
            for first in range(0, scan.size, rows):
                found = list(islice(lines, min(rows, scan.size - first)))
                if first + len(found) < min(first + rows, scan.size):
                    raise self.source.changed()
                try:
                    yield number, _points_of(found, first, header, scan)
                except ValueError as error:
                    raise self._failure(number, error) from error

    def _failure(self, number: int, error: ValueError) -> CloudFileError:
        return CloudFileError(
            self.name,
            f"scan {number}: {excerpt(str(error))}",
            "get the whole file again, or export it again",
        )


def _lines_of(source: ByteSource) -> Iterator[bytes]:
    """Give all lines of a file that are not blank."""
    return chain.from_iterable(
        _lines(block, first=position == 0) for position, block in source.line_blocks(0, source.size)
    )


def _lines(data: bytes, *, first: bool = True) -> list[bytes]:
    data = data.removeprefix(b"\xef\xbb\xbf") if first else data
    return [line for line in data.splitlines() if line.strip()]


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


def _scan_below(header: _Header, lines: Iterator[bytes]) -> Scan:
    """Pass over the points below a header; `ValueError` if there are fewer, or of unknown width."""
    n_points = header.columns * header.rows
    rows = islice(lines, n_points)
    first = next(rows, b"")
    n_rows = bool(first) + sum(1 for _ in rows)
    if n_rows < n_points:
        raise ValueError(
            f"it promises {n_points} points ({header.columns} columns of {header.rows}), but "
            f"{n_rows} lines follow"
        )
    width = len(first.split()) if first else len("xyz")
    if width not in _NAMES:
        raise ValueError(
            f"a point has {width} values, '{first.decode('latin-1').strip()}', not 3, 4, 6 or 7"
        )
    return Scan(
        n_points,
        {name: np.dtype(np.uint8 if name in COLORS else np.float64) for name in _NAMES[width]},
    )


def _points_of(rows: Sequence[bytes], first: int, header: _Header, scan: Scan) -> ScanPoints:
    """Read points of a scan, of which the first has a number."""
    axes = ("x", "y", "z")
    types = [*((axis, np.dtype(np.float64)) for axis in axes), *scan.types.items()]
    table = read_rows(rows, np.dtype(types), [name for name, _ in types], first)
    xyz = np.stack([table[axis] for axis in axes], axis=1)
    xyz[(xyz == 0.0).all(axis=1)] = np.nan
    xyz = moved(xyz, header.matrix[:3, :3], header.matrix[3, :3])
    return ScanPoints(xyz, {name: table[name] for name in scan.types})
