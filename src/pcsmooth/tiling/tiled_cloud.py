"""A cloud on disk as a cloud in parts: tiles, on which a runner works."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.grid.grid import CELL_OF_ZERO
from pcsmooth.neighbors.grid import is_in_range
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Around, PartStep, Result
from pcsmooth.progress import Callback, Progress, ignore
from pcsmooth.tiling.column_store import FileColumn
from pcsmooth.tiling.partition import Partition
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.tile_store import TileStore


@dataclass(frozen=True, eq=False)
class TiledCloud:
    """The finite points of a cloud in tiles on disk (see `Parts`).

    Attributes
    ----------
    store : TileStore
        The tiles.
    runner : Runner
        Does the work on them.
    callback : callable
        Told how far each stage is.
    """

    store: TileStore
    runner: Runner
    callback: Callback = ignore
    _files: dict[str, str] = field(default_factory=dict, repr=False)
    _numbers: Iterator[int] = field(default_factory=count, repr=False)

    @property
    def dimension(self) -> int:
        """Number of coordinates of a point, 2 or 3."""
        return self.store.dimension

    @property
    def count(self) -> int:
        """Number of points."""
        return self.store.count

    @property
    def n_parts(self) -> int:
        """Number of tiles."""
        return self.store.partition.n_tiles

    @property
    def origin(self) -> npt.NDArray[np.float64]:
        """What was subtracted from all positions, (d,), in the unit of the input."""
        return self.store.origin

    @property
    def unit(self) -> float:
        """What all lengths are multiples of, in the unit of the input."""
        return self.store.unit

    @property
    def box(self) -> npt.NDArray[np.float64]:
        """Bounding box at the start, (2, d), L."""
        return self.store.box

    @property
    def start(self) -> FileColumn:
        """Position of each point at the start."""
        return self.store.start

    @property
    def fixed(self) -> FileColumn:
        """Whether each point is fixed."""
        return self.store.fixed

    @property
    def given(self) -> FileColumn | None:
        """Normal that each point came with."""
        return self.store.given if self.store.has_normals else None

    def create(self, name: str, dtype: npt.DTypeLike) -> FileColumn:
        """Create a column of zeros, in a file of its own.

        A worker that was given up may still write to an earlier one of the same name.
        """
        self._files[name] = f"{name}_{next(self._numbers)}"
        return self.store.create(self._files[name], dtype)

    def drop(self, *names: str) -> None:
        """Remove columns, as far as there are any."""
        self.store.drop(*(self._files.pop(name) for name in names if name in self._files))

    def forget(self, *keys: str) -> None:
        """Do nothing: tiles remember nothing."""

    def map(
        self, stage: str, step: PartStep[Result], points: Column, drift: float = 0.0
    ) -> Iterator[Result]:
        """Do a step on all tiles: see `Parts.map`."""
        n_tiles, reach = self.n_parts, step.reach
        self.callback(Progress(stage, 0, n_tiles))
        reaches = [reach] * n_tiles if isinstance(reach, float) else reach.of_parts(drift).tolist()
        tasks = ((self.store, tile, step, points, reaches[tile], drift) for tile in range(n_tiles))
        for done, result in enumerate(self.runner.map(_do, tasks), 1):
            yield result
            self.callback(Progress(stage, done, n_tiles))

    def largest_around(self, column: Column) -> Around:
        """Tell how large the values of a column are around each tile, cube by cube."""
        partition = self.store.partition
        largest = np.empty(len(partition.codes))
        for tile in range(self.n_parts):
            first, stop = partition.tile_starts[tile : tile + 2]
            starts = partition.starts[first:stop]
            values = column.read(int(starts[0]), int(partition.starts[stop]))
            largest[first:stop] = np.maximum.reduceat(values, starts - starts[0])
        return _LargestAround(partition, largest)

    def check_width(self, box: npt.NDArray[np.float64], cell_size: float, cells: str) -> None:
        """Raise `InvalidInputError` if tiles would not have the cells of the whole."""
        if not is_in_range(box, cell_size, box[0]):
            width = float(np.ptp(box, axis=0).max()) * self.unit
            raise InvalidInputError(
                f"the cloud is {width:.3g} wide, more than {CELL_OF_ZERO:,} times {cells} "
                f"({cell_size * self.unit:.3g}), and tiles would not give the same result as the "
                "whole; remove far outliers, choose a larger radius or shorter steps, or pass tile "
                "off"
            )


@dataclass(frozen=True, eq=False)
class _LargestAround:
    """The largest value of a column around each tile (see `Around`).

    Attributes
    ----------
    partition : Partition
        The tiles.
    values : ndarray, shape (m,)
        The largest in each cube.
    """

    partition: Partition
    values: npt.NDArray[np.float64]

    @property
    def n_parts(self) -> int:
        return self.partition.n_tiles

    def __call__(self, distances: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.array(
            [
                self.partition.largest_near(tile, distance, self.values)
                for tile, distance in enumerate(distances.tolist())
            ]
        )


def _do(
    store: TileStore,
    tile: int,
    step: PartStep[Any],
    points: FileColumn,
    reach: float,
    drift: float,
) -> Any:
    """Do a step on a tile."""
    part: Any = store.tile(tile, points, reach, drift)  # its columns are files
    return step(part)
