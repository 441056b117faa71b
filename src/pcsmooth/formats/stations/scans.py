"""Several scans, each moved to its place, as one cloud."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.cloud_file import CloudChunks
from pcsmooth.formats.coordinates import split_coordinates

Columns = dict[str, npt.NDArray[Any]]

_SCAN = "scan"


class Scan(NamedTuple):
    """What was measured from one station, without its points.

    Attributes
    ----------
    size : int
        Number of points.
    types : mapping of str to numpy.dtype
        Its columns.
    """

    size: int
    types: Mapping[str, np.dtype[Any]]


class ScanPoints(NamedTuple):
    """Consecutive points of a scan.

    Attributes
    ----------
    xyz : ndarray of float64, shape (n, 3)
        Positions in the system of all scans, L; NaN where nothing was measured.
    columns : dict of str to ndarray, each of shape (n,)
        What else there is.
    """

    xyz: npt.NDArray[np.float64]
    columns: Columns


def moved(
    xyz: npt.NDArray[np.float64], matrix: npt.NDArray[np.float64], shift: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Move rows by a matrix, which they are multiplied with, and a shift.

    Each is rounded alike in however many others; the products of a single one would not be.
    """
    several = xyz if len(xyz) != 1 else np.repeat(xyz, 2, axis=0)
    with np.errstate(over="ignore", invalid="ignore"):
        return (several @ matrix)[: len(xyz)] + shift


class ScanChunks(CloudChunks):
    """The points of every scan of a file, one scan after the other.

    The column ``scan`` counts scans from 0; columns that a scan lacks are NaN, or 0 where they are
    whole numbers.

    Parameters
    ----------
    source : ByteSource
        The file.
    dim : {2, 3} or None
        Number of coordinates; with 2 the third is a column.
    scans : sequence of Scan
        Those of the file, in its order.
    comments : sequence of str
        What the file says.
    """

    def __init__(
        self, source: ByteSource, dim: int | None, scans: Sequence[Scan], comments: Sequence[str]
    ) -> None:
        super().__init__(source)
        self._dim, self._scans, self._comments = dim, scans, tuple(comments)
        self.count = sum(scan.size for scan in scans)
        names = dict.fromkeys(name for scan in scans for name in scan.types)
        self._types = {
            name: np.result_type(*(scan.types[name] for scan in scans if name in scan.types))
            for name in names
        }

    @cached_property
    def template(self) -> PointCloud:
        """The cloud without its points."""
        return self._cloud(np.empty((0, 3)), self._columns(0))

    @abstractmethod
    def _blocks(self, rows: int) -> Iterator[tuple[int, ScanPoints]]:
        """Read all points, each block with the number of its scan and no more than so many rows."""

    def _clouds(self, rows: int, columns: bool) -> Iterator[PointCloud]:
        blocks = self._blocks(rows)
        number, block, used = 0, ScanPoints(np.empty((0, 3)), {}), 0
        for first in range(0, self.count, rows):
            size = min(rows, self.count - first)
            xyz, values = np.empty((size, 3)), self._columns(size)
            filled = 0
            while filled < size:
                if used == len(block.xyz):
                    (number, block), used = next(blocks), 0
                taken = slice(used, used + size - filled)
                place = slice(filled, filled + len(block.xyz[taken]))
                xyz[place] = block.xyz[taken]
                values[_SCAN][place] = number
                for name, column in block.columns.items():
                    values[name][place] = column[taken]
                used += place.stop - filled
                filled = place.stop
            yield self._cloud(xyz, values, columns)

    def _columns(self, size: int) -> Columns:
        """Columns of so many points, of which nothing is known."""
        if not self._scans:
            return {}
        number = np.min_scalar_type(max(len(self._scans), 1 << 16) - 1)
        types = {_SCAN: number, **self._types}
        return {
            name: np.full(size, np.nan if kind.kind == "f" else 0, kind)
            for name, kind in types.items()
        }

    def _cloud(
        self, xyz: npt.NDArray[np.float64], values: Columns, columns: bool = True
    ) -> PointCloud:
        points, height = split_coordinates(xyz, self._dim)
        return PointCloud(points, {**height, **values} if columns else {}, comments=self._comments)
