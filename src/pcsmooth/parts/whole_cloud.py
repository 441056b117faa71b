"""A cloud in memory: one part, which is all of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import NoFinitePointError
from pcsmooth.kernels.grid.grid import bounding_box
from pcsmooth.parts.column import ArrayColumn, Column
from pcsmooth.parts.part import Around, PartStep, Result
from pcsmooth.point_order import take_in_order
from pcsmooth.progress import Callback, Progress, ignore
from pcsmooth.unit_of_length import unit_for

#: Points from which is told how large lengths are.
_SAMPLES = 10_000


@dataclass(frozen=True, eq=False)
class WholeCloud:
    """The finite points of a cloud in memory (see `Parts`).

    Attributes
    ----------
    start : ArrayColumn
        Positions at the start, L, seen from the origin.
    origin : ndarray, shape (d,)
        What was subtracted, in the unit of the input.
    unit : float
        What all lengths are multiples of, in the unit of the input.
    input_rows : ndarray of int, shape (n,)
        Row of each point in the input.
    fixed : ArrayColumn
        Whether each point is fixed.
    given : ArrayColumn or None
        Normal that each point came with.
    callback : callable
        Told when a stage begins and ends.
    """

    start: ArrayColumn
    origin: npt.NDArray[np.float64]
    unit: float
    input_rows: npt.NDArray[np.int64]
    fixed: ArrayColumn
    given: ArrayColumn | None = None
    callback: Callback = ignore
    _memory: dict[str, Any] = field(default_factory=dict, repr=False)

    n_parts = 1

    @classmethod
    def of(
        cls,
        positions: npt.NDArray[np.float64],
        usable: npt.NDArray[np.bool_] | None = None,
        *,
        fixed: npt.NDArray[np.bool_] | None = None,
        given: npt.NDArray[np.float64] | None = None,
        callback: Callback = ignore,
    ) -> WholeCloud:
        """Take the points of a cloud in order.

        Parameters
        ----------
        positions : ndarray, shape (n, d)
            Positions, in the unit of the input.
        usable : ndarray of bool, shape (n,), optional
            Those that are finite; all by default.
        fixed : ndarray of bool, shape (n,), optional
            Those that are fixed.
        given : ndarray, shape (n, d), optional
            Normals they come with, zero for none.
        callback : callable
            Told when a stage begins and ends.

        Raises
        ------
        NoFinitePointError
            There is none.
        InvalidInputError
            The points are too near or too far to be measured.
        """
        if usable is None:
            usable = np.ones(len(positions), np.bool_)
        if not usable.any():
            raise NoFinitePointError
        taken = take_in_order(positions, usable, given)
        points, rows = taken.points, taken.rows
        unit = unit_for(points, _typical_distance(points))
        if unit != 1.0:
            points /= unit
        return cls(
            ArrayColumn(points),
            taken.origin,
            unit,
            rows,
            ArrayColumn(np.zeros(len(rows), np.bool_) if fixed is None else fixed[rows]),
            None if given is None else ArrayColumn(given[rows]),
            callback,
        )

    @classmethod
    def as_it_is(
        cls, points: npt.NDArray[np.float64], fixed: npt.NDArray[np.bool_] | None = None
    ) -> WholeCloud:
        """Take finite points (n, d) and marks of those that are fixed in their order and unit."""
        n, dimension = points.shape
        marks = np.zeros(n, np.bool_) if fixed is None else fixed
        rows = np.arange(n)
        return cls(ArrayColumn(points), np.zeros(dimension), 1.0, rows, ArrayColumn(marks))

    @property
    def dimension(self) -> int:
        """Number of coordinates of a point, 2 or 3."""
        return int(self.start.values.shape[1])

    @property
    def count(self) -> int:
        """Number of points."""
        return self.start.rows

    @cached_property
    def box(self) -> npt.NDArray[np.float64]:
        """Bounding box at the start, (2, d), L."""
        return np.array(bounding_box(self.start.values))[:, : self.dimension]

    def create(self, name: str, dtype: npt.DTypeLike) -> Column:
        """Create a column of zeros; it lasts as long as it is held."""
        return ArrayColumn.zeros(dtype, self.count)

    def drop(self, *names: str) -> None:
        """Do nothing: columns go when they are not held any more."""

    def forget(self, *keys: str) -> None:
        """Forget what was to be remembered, all of it if no name is given."""
        for key in keys or tuple(self._memory):
            self._memory.pop(key, None)

    def remembered(self, key: str, make: Callable[[], Result]) -> Result:
        """Make something, or take what was made before under this name."""
        if key not in self._memory:
            self._memory[key] = make()
        return self._memory[key]  # type: ignore[no-any-return]

    def map(
        self, stage: str, step: PartStep[Result], points: Column, drift: float = 0.0
    ) -> Iterator[Result]:
        """Do a step on all points: see `Parts.map`."""
        self.callback(Progress(stage, 0, 1))
        yield step(_Whole(self, points))
        self.callback(Progress(stage, 1, 1))

    def largest_around(self, column: Column) -> Around:
        """Give the largest of all: there is nothing around the whole."""
        return _Largest(float(column.read(0, self.count).max()))

    def check_width(self, box: npt.NDArray[np.float64], cell_size: float, cells: str) -> None:
        """Do nothing: the cells of the whole are what they are."""


@dataclass(frozen=True)
class _Largest:
    """The largest value of a column, whatever the distance (see `Around`)."""

    value: float

    n_parts = 1

    def __call__(self, distances: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.full(len(distances), self.value)


@dataclass(frozen=True, eq=False)
class _Whole:
    """All points of a cloud as its only part (see `Part`)."""

    cloud: WholeCloud
    column: Column

    first = 0
    own = slice(None)

    @property
    def stop(self) -> int:
        return self.cloud.count

    @property
    def rows(self) -> npt.NDArray[np.int64]:
        return np.arange(self.cloud.count)

    @property
    def points(self) -> npt.NDArray[np.float64]:
        return self.column.read(0, self.cloud.count)

    def read(self, column: Column) -> npt.NDArray[Any]:
        return column.read(0, self.cloud.count)

    def write(self, column: Column, values: npt.NDArray[Any]) -> None:
        column.write(0, values)

    def remember(self, key: str, make: Callable[[], Result]) -> Result:
        return self.cloud.remembered(key, make)


def _typical_distance(points: npt.NDArray[np.float64]) -> float:
    """Median distance between points (n, d) that follow each other and are not at one place, L.

    Along a Morton curve that is a few spacings, which is all that a unit has to know.
    """
    every = -(-len(points) // _SAMPLES)
    steps = np.linalg.norm(points[1::every] - points[:-1:every], axis=1)
    steps = steps[steps > 0.0]
    return float(np.median(steps)) if len(steps) else 0.0
