"""A cloud on disk: columns of points in the order of a partition, loaded tile by tile."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.grid.grid import CELL_OF_ZERO
from pcsmooth.neighbors import is_in_range
from pcsmooth.tiling.column_store import Column
from pcsmooth.tiling.near_points import near_points
from pcsmooth.tiling.partition import Partition


@dataclass(frozen=True, eq=False)
class TiledCloud:
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
    """

    folder: Path
    partition: Partition
    origin: npt.NDArray[np.float64]
    unit: float
    box: npt.NDArray[np.float64]

    @property
    def dimension(self) -> int:
        """Number of coordinates of a point, 2 or 3."""
        return len(self.origin)

    @property
    def count(self) -> int:
        """Number of points."""
        return int(self.partition.starts[-1])

    def column(self, name: str, dtype: npt.DTypeLike) -> Column:
        """Name a column that has been created."""
        return Column(str(self.folder / f"{name}.bin"), np.dtype(dtype), self.count)

    def create(self, name: str, dtype: npt.DTypeLike) -> Column:
        """Create a column, or empty it."""
        column = self.column(name, dtype)
        return Column.create(column.path, column.dtype, self.count)

    def drop(self, *names: str) -> None:
        """Remove columns, as far as there are any."""
        for name in names:
            (self.folder / f"{name}.bin").unlink(missing_ok=True)

    def points(self, name: str) -> Column:
        """Name a column of vectors."""
        return self.column(name, (np.float64, (self.dimension,)))

    @property
    def numbers(self) -> Column:
        """Place of each point among the finite ones of the input."""
        return self.column("number", np.int64)

    @property
    def start(self) -> Column:
        """Position of each point at the start, L, seen from the origin."""
        return self.points("start")

    @property
    def given(self) -> Column:
        """Normal that each point came with, zero for none."""
        return self.points("given")

    @property
    def fixed(self) -> Column:
        """Whether each point is fixed."""
        return self.column("fixed", np.bool_)

    def tile(self, number: int, points: Column, halo: float, drift: float) -> Tile:
        """Load a tile and what is near it.

        Parameters
        ----------
        number : int
            Which.
        points : Column
            Positions now, L.
        halo : float
            All points within this distance of an own one along every axis are loaded, L, > 0.
        drift : float
            Most that any point has moved from its start along an axis, L.

        Returns
        -------
        Tile
        """
        first, stop = self.partition.rows(number)
        runs = self.partition.halo(number, halo + 2.0 * drift)
        near = near_points(points.read(first, stop), points.read_runs(runs), halo)
        # Runs do not overlap the tile's own: sorted, all are one list of rows.
        before = runs[:, 0] < first
        runs = np.concatenate([runs[before], [[first, stop]], runs[~before]])
        n_before = int(np.diff(runs[: np.count_nonzero(before)], axis=1).sum())
        kept = np.concatenate([near[:n_before], np.ones(stop - first, np.bool_), near[n_before:]])
        rows = np.concatenate([np.arange(a, b) for a, b in runs.tolist()])[kept]
        own = np.arange(stop - first) + np.count_nonzero(near[:n_before])
        return Tile(first, runs, kept, rows, own, points.read_runs(runs)[kept])


def check_width(
    box: npt.NDArray[np.float64], cell_size: float, corner: npt.NDArray[np.float64] | None = None
) -> None:
    """Raise `InvalidInputError` if a cloud is too wide for its tiles to have the whole's cells.

    Parameters
    ----------
    box : ndarray, shape (2, d)
        Bounding box, L.
    cell_size : float
        Side of a cell, L.
    corner : ndarray, shape (d,), optional
        Where a cell begins, L; by default 0.
    """
    if not is_in_range(box, cell_size, corner):
        raise InvalidInputError(
            f"the cloud is wider than {CELL_OF_ZERO:,} times {cell_size:.3g}, and tiles would not "
            "give the same result as the whole; choose a larger radius, remove far outliers, or "
            "pass tile off"
        )


@dataclass(frozen=True, eq=False)
class Tile:
    """Points of a tile and around it, in the order of the cloud's rows.

    Attributes
    ----------
    first : int
        First of the rows that are the tile's own.
    runs : ndarray of int, shape (k, 2)
        Rows that were read.
    kept : ndarray of bool
        Which of these are those of the points.
    rows : ndarray of int, shape (m,)
        Row of each point, increasing.
    own : ndarray of int, shape (k,)
        Which of the points are the tile's own: consecutive ones.
    points : ndarray, shape (m, d)
        Positions now, L.
    """

    first: int
    runs: npt.NDArray[np.int64]
    kept: npt.NDArray[np.bool_]
    rows: npt.NDArray[np.int64]
    own: npt.NDArray[np.int64]
    points: npt.NDArray[np.float64]

    def read(self, column: Column) -> npt.NDArray[Any]:
        """Read a column at all points, in their order."""
        return np.asarray(column.read_runs(self.runs)[self.kept])

    def write(self, column: Column, values: npt.NDArray[Any]) -> None:
        """Write values of all points, as far as they are the tile's own."""
        column.write(self.first, values[self.own])
