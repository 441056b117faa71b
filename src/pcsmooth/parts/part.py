"""What a cloud in parts offers, and what is done to its parts.

All that denoises or estimates is written once, as steps over the parts of a cloud. What a step
finds at a point depends on nothing but the points within its reach, in an order that is the same
in every part, so that the result is the same to the last bit however the cloud is cut (but of
implicit steps, see `pcsmooth.flows.flow`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from pcsmooth.parts.column import Column

Result = TypeVar("Result")
ResultOfStep = TypeVar("ResultOfStep", covariant=True)


class Part(Protocol):
    """Some points of a cloud with all that are within the reach of a step.

    Points are in the order of the cloud's rows.
    """

    @property
    def first(self) -> int:
        """First of the rows that are the part's own."""

    @property
    def stop(self) -> int:
        """Row after the last of them."""

    @property
    def rows(self) -> npt.NDArray[np.int64]:
        """Row of each point, (m,), increasing."""

    @property
    def own(self) -> slice:
        """Which of the points are the part's own."""

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """Positions now, (m, d), L; not to be written to."""

    def read(self, column: Column) -> npt.NDArray[Any]:
        """Read a column at all points; not to be written to."""

    def write(self, column: Column, values: npt.NDArray[Any]) -> None:
        """Write values of all points, as far as they are the part's own.

        The array may be taken over: it is not to be written to afterwards.
        """

    def remember(self, key: str, make: Callable[[], Result]) -> Result:
        """Make something of the points, or take what was made before under this name.

        A cloud in memory remembers it until `Parts.forget`: who moves points has forgotten what
        depends on where they are. Any other makes it anew.
        """


class Reach(Protocol):
    """How far a step looks from the points of each part."""

    def of_parts(self, drift: float) -> npt.NDArray[np.float64]:
        """Tell it of all parts, (n_parts,), along an axis, L.

        By the most that any point has moved from its start along an axis, L.
        """


class Around(Protocol):
    """What the largest value is that points around the parts have."""

    @property
    def n_parts(self) -> int:
        """Number of parts."""

    def __call__(self, distances: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Find the largest within a distance, L, of the points of each part, (n_parts,).

        Along every axis and at the start; or a larger one, of points not much farther.
        """


class PartStep(Protocol[ResultOfStep]):
    """Work on a part. It can be pickled, and may run more than once on a part."""

    @property
    def reach(self) -> float | Reach:
        """How far it looks from a point, along an axis, L; 0 if it looks at own points only."""

    def __call__(self, part: Part) -> ResultOfStep:
        """Do it; what is written are rows of the part's own, always the same."""


class Parts(Protocol):
    """The finite points of a cloud, in parts.

    Rows are in the order in which points are taken (see `order_by_position`), whatever that of
    the input.
    """

    @property
    def dimension(self) -> int:
        """Number of coordinates of a point, 2 or 3."""

    @property
    def count(self) -> int:
        """Number of points, >= 1."""

    @property
    def n_parts(self) -> int:
        """Number of parts."""

    @property
    def origin(self) -> npt.NDArray[np.float64]:
        """What was subtracted from all positions, (d,), in the unit of the input."""

    @property
    def unit(self) -> float:
        """What all lengths are multiples of, in the unit of the input; a power of two."""

    @property
    def box(self) -> npt.NDArray[np.float64]:
        """Bounding box at the start, (2, d), L."""

    @property
    def start(self) -> Column:
        """Position of each point at the start, (d,), L, seen from the origin."""

    @property
    def fixed(self) -> Column:
        """Whether each point is fixed."""

    @property
    def given(self) -> Column | None:
        """Normal that each point came with, (d,), zero for none; None if none are looked at."""

    def create(self, name: str, dtype: npt.DTypeLike) -> Column:
        """Create a column of zeros, whatever there was of this name."""

    def drop(self, *names: str) -> None:
        """Remove columns, as far as there are any."""

    def forget(self, *keys: str) -> None:
        """Forget what parts were to remember, all of it if no name is given."""

    def map(
        self, stage: str, step: PartStep[Result], points: Column, drift: float = 0.0
    ) -> Iterator[Result]:
        """Do a step on every part.

        Parameters
        ----------
        stage : str
            What it is called, for those who wait.
        step : PartStep
            What to do.
        points : Column
            Positions now, L.
        drift : float
            Most that any point has moved from its start along an axis, L.

        Yields
        ------
        object
            What the step gives, in the order of the parts.
        """

    def largest_around(self, column: Column) -> Around:
        """Tell how large the values of a column are around each part.

        Parameters
        ----------
        column : Column
            A number for each point.
        """

    def check_width(self, box: npt.NDArray[np.float64], cell_size: float, cells: str) -> None:
        """Raise `InvalidInputError` if the cloud is too wide for its parts to have its cells.

        Parameters
        ----------
        box : ndarray, shape (2, d)
            Bounding box, L, at whose corner cells begin.
        cell_size : float
            Side of a cell, L.
        cells : str
            What is as wide, for the message.
        """
