"""A point cloud in memory: positions to compute with, and everything else untouched."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

NORMALS = ("nx", "ny", "nz")
"""Names of the columns of a normal."""

COLORS = ("red", "green", "blue")
"""Names of the columns of a color."""


@dataclass(frozen=True)
class PointCloud:
    """Positions in double precision, and every other column as the file had it.

    Attributes
    ----------
    points : ndarray of float64, shape (n, d)
        Positions, d = 2 or 3, in the length unit of the file.
    columns : dict of str to ndarray, each of length n
        Every other per-point column, in file order and with the file's own type. Numbers keep
        their dtype; list properties are object arrays; columns of text files are arrays of
        str, spelled as in the file.
    position_type : numpy.dtype
        Type that the positions had in the file and will have when written.
    comments : tuple of str
        Comments of the file's header, without their marker.
    fixed_marks : ndarray of bool, shape (n,), optional
        Rows that ended in the word ``fixed`` (text files only); None if there was none.
    noise_marks : ndarray of bool, shape (n,), optional
        Rows that the file itself calls noise, and that take part in nothing; None if there is
        none.
    layout : object, optional
        What only the format that read the file knows: encoding, delimiters, other elements.
        It is handed back to the same format on writing and ignored by every other.
    warnings : tuple of str
        What a reader found amiss in the file and read nevertheless, a sentence each, for the user.
    """

    points: npt.NDArray[np.float64]
    columns: dict[str, npt.NDArray[Any]] = field(default_factory=dict)
    position_type: np.dtype[Any] = field(default_factory=lambda: np.dtype(np.float64))
    comments: tuple[str, ...] = ()
    fixed_marks: npt.NDArray[np.bool_] | None = None
    noise_marks: npt.NDArray[np.bool_] | None = None
    layout: object | None = None
    warnings: tuple[str, ...] = ()

    @property
    def dimension(self) -> int:
        """Number of coordinates of a point, 2 or 3."""
        return int(self.points.shape[1])

    @property
    def active_points(self) -> npt.NDArray[np.float64]:
        """Positions (n, d) of the rows that take part, NaN in those marked as noise."""
        if self.noise_marks is None:
            return self.points
        return np.where(self.noise_marks[:, np.newaxis], np.nan, self.points)

    def without_marks(self) -> PointCloud:
        """Let points that the file calls noise take part."""
        return replace(self, noise_marks=None)

    @property
    def noise_count(self) -> int:
        """Number of points that the file calls noise and that take no part."""
        return 0 if self.noise_marks is None else int(self.noise_marks.sum())

    def __repr__(self) -> str:
        """Say how many points there are, and which columns."""
        columns = f", columns {' '.join(self.columns)}" if self.columns else ""
        return f"<PointCloud of {len(self)} points in {self.dimension}D{columns}>"

    def __len__(self) -> int:
        """Return the number of points."""
        return int(self.points.shape[0])
