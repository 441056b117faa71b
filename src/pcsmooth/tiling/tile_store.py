"""A cloud on disk: columns of points in the order of a partition, loaded tile by tile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.parts.part import Result
from pcsmooth.tiling.column_store import FileColumn
from pcsmooth.tiling.partition import Partition
from pcsmooth.tiling.within_reach import within_reach


@dataclass(frozen=True, eq=False)
class TileStore:
    """The finite points of a cloud, sorted into tiles.

    Attributes
    ----------
    folder : Path
        Where the columns lie, on a disk that all workers see.
    partition : Partition
        The tiles.
    origin : ndarray, shape (d,)
        What was subtracted from all positions, in the unit of the input.
    unit : float
        What all lengths in the tiles are multiples of, in the unit of the input; a power of two.
    box : ndarray, shape (2, d)
        Bounding box at the start, L.
    has_normals : bool
        Whether there is a column of normals that the points came with.
    """

    folder: Path
    partition: Partition
    origin: npt.NDArray[np.float64]
    unit: float
    box: npt.NDArray[np.float64]
    has_normals: bool = False

    @property
    def dimension(self) -> int:
        """Number of coordinates of a point, 2 or 3."""
        return len(self.origin)

    @property
    def count(self) -> int:
        """Number of points."""
        return int(self.partition.starts[-1])

    def column(self, name: str, dtype: npt.DTypeLike) -> FileColumn:
        """Name a column that has been created."""
        return FileColumn(str(self.folder / f"{name}.bin"), np.dtype(dtype), self.count)

    def create(self, name: str, dtype: npt.DTypeLike) -> FileColumn:
        """Create a column, or empty it."""
        column = self.column(name, dtype)
        return FileColumn.create(column.path, column.dtype, self.count)

    def drop(self, *names: str) -> None:
        """Remove columns, as far as there are any."""
        for name in names:
            (self.folder / f"{name}.bin").unlink(missing_ok=True)

    def points(self, name: str) -> FileColumn:
        """Name a column of vectors."""
        return self.column(name, (np.float64, (self.dimension,)))

    @property
    def numbers(self) -> FileColumn:
        """Place of each point among the finite ones of the input."""
        return self.column("number", np.int64)

    @property
    def start(self) -> FileColumn:
        """Position of each point at the start, L, seen from the origin."""
        return self.points("start")

    @property
    def given(self) -> FileColumn:
        """Normal that each point came with, zero for none."""
        return self.points("given")

    @property
    def fixed(self) -> FileColumn:
        """Whether each point is fixed."""
        return self.column("fixed", np.bool_)

    def tile(self, number: int, points: FileColumn, halo: float, drift: float) -> Tile:
        """Name a tile and what is near it, which is loaded as it is asked for.

        Parameters
        ----------
        number : int
            Which.
        points : FileColumn
            Positions now, L.
        halo : float
            All points within this distance of an own one along every axis are loaded, L; none but
            the own ones if it is 0.
        drift : float
            Most that any point has moved from its start along an axis, L.

        Returns
        -------
        Tile
        """
        first, stop = self.partition.rows(number)
        return Tile(self.partition, number, first, stop, points, halo, drift)


@dataclass(frozen=True, eq=False)
class Tile:
    """Points of a tile and around it, in the order of the cloud's rows (see `Part`).

    Attributes
    ----------
    partition : Partition
        All tiles.
    number : int
        Which it is.
    first, stop : int
        The tile's own rows.
    column : FileColumn
        Positions now, L.
    halo, drift : float
        See `TileStore.tile`.
    """

    partition: Partition
    number: int
    first: int
    stop: int
    column: FileColumn
    halo: float
    drift: float

    @cached_property
    def _chosen(self) -> _Rows:
        """Find out which rows are near enough."""
        first, stop = self.first, self.stop
        if self.halo == 0.0:
            return _Rows(np.array([[first, stop]]), None, 0)
        runs = self.partition.halo(self.number, self.halo + 2.0 * self.drift)
        near = within_reach(self.column.read(first, stop), self.column.read_runs(runs), self.halo)
        # Runs do not overlap the tile's own: sorted, all are one list of rows.
        before = runs[:, 0] < first
        runs = np.concatenate([runs[before], [[first, stop]], runs[~before]])
        n_before = int(np.diff(runs[: np.count_nonzero(before)], axis=1).sum())
        kept = np.concatenate([near[:n_before], np.ones(stop - first, np.bool_), near[n_before:]])
        return _Rows(runs, kept, int(np.count_nonzero(near[:n_before])))

    @cached_property
    def rows(self) -> npt.NDArray[np.int64]:
        """Row of each point, (m,), increasing."""
        rows = np.concatenate([np.arange(a, b) for a, b in self._chosen.runs.tolist()])
        return rows if self._chosen.kept is None else rows[self._chosen.kept]

    @cached_property
    def own(self) -> slice:
        """Which of the points are the tile's own."""
        begin = self._chosen.n_before
        return slice(begin, begin + self.stop - self.first)

    @cached_property
    def points(self) -> npt.NDArray[np.float64]:
        """Positions now, (m, d), L."""
        return self.read(self.column)

    def read(self, column: FileColumn) -> npt.NDArray[Any]:
        """Read a column at all points, in their order."""
        values = column.read_runs(self._chosen.runs)
        return np.asarray(values if self._chosen.kept is None else values[self._chosen.kept])

    def write(self, column: FileColumn, values: npt.NDArray[Any]) -> None:
        """Write values of all points, as far as they are the tile's own."""
        column.write(self.first, values[self.own])

    def remember(self, _key: str, make: Callable[[], Result]) -> Result:
        """Make it: tiles remember nothing."""
        return make()


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows that are read, which of these are kept (all if None), and how many are before the own.

    Runs are (k, 2), marks (m,).
    """

    runs: npt.NDArray[np.int64]
    kept: npt.NDArray[np.bool_] | None
    n_before: int
