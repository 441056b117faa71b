"""Values of the points of a cloud: a row for each point, in memory or elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

#: Rows that are gone through at a time.
CHUNK = 1 << 20


class Column(Protocol):
    """Rows of one size, the same row for the same point in every column."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of a row: a number, a structure, or a sub-array such as ``("f8", (3,))``."""

    @property
    def rows(self) -> int:
        """How many there are."""

    def read(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Read the rows from `start` up to, not including, `stop`; not to be written to."""

    def take(self, rows: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
        """Read some rows, increasing."""

    def write(self, start: int, values: npt.NDArray[Any]) -> None:
        """Write rows from `start` on; to write the same rows again changes nothing.

        The array may be taken over: it is not to be written to afterwards.
        """

    def chunks(self, rows: int = CHUNK) -> Iterator[npt.NDArray[Any]]:
        """Read all rows, so many at a time."""


@dataclass(eq=False)
class ArrayColumn:
    """A column in memory.

    What is written as a whole is taken over, not copied: nobody else may write to it afterwards.

    Attributes
    ----------
    values : ndarray, shape (n,) or, of sub-arrays, (n, ...)
        The rows.
    """

    values: npt.NDArray[Any]

    @classmethod
    def zeros(cls, dtype: npt.DTypeLike, rows: int) -> ArrayColumn:
        """Make a column of zeros."""
        return cls(np.zeros(rows, dtype))

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of a row."""
        return np.dtype((self.values.dtype, self.values.shape[1:]))

    @property
    def rows(self) -> int:
        """How many there are."""
        return len(self.values)

    def read(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Show some rows."""
        return self.values[start:stop]

    def take(self, rows: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
        """Copy some rows."""
        return self.values[rows]

    def write(self, start: int, values: npt.NDArray[Any]) -> None:
        """Take over all rows, or copy some in."""
        if values.shape == self.values.shape and values.dtype == self.values.dtype:
            self.values = values
            return
        self.values[start : start + len(values)] = values

    def chunks(self, rows: int = CHUNK) -> Iterator[npt.NDArray[Any]]:
        """Show all rows, so many at a time."""
        for start in range(0, len(self.values), rows):
            yield self.values[start : start + rows]
