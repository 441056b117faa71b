"""Which points of a file take part in a run, and which of these stay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pcsmooth.errors import CloudFileError
from pcsmooth.files.fixed_points import fixed_points
from pcsmooth.positions import usable_rows

if TYPE_CHECKING:
    import numpy.typing as npt

    from pcsmooth.cloud import PointCloud
    from pcsmooth.files.selection import Selection


@dataclass(frozen=True)
class TakingPart:
    """What decides on it.

    Attributes
    ----------
    path : str
        The file, for messages.
    fixed_column : str, optional
        Column of the fixed points (see `fixed_points`).
    selection : Selection, optional
        Which points are selected; by default all. The others stay, or take no part.
    moves : bool
        Whether points move at all; if not, only the others are told apart as those that stay.
    """

    path: str
    fixed_column: str | None = None
    selection: Selection | None = None
    moves: bool = True

    def selected(self, cloud: PointCloud) -> npt.NDArray[np.bool_] | None:
        """Tell which rows are selected, (n,); None if that are all."""
        return None if self.selection is None else self.selection.selected(cloud, self.path)

    def positions(
        self, cloud: PointCloud, selected: npt.NDArray[np.bool_] | None
    ) -> npt.NDArray[np.float64]:
        """Positions (n, d) of the rows that take part, NaN in the others."""
        points = cloud.active_points
        if selected is None or not self.ignores_others:
            return points
        return np.where(selected[:, np.newaxis], points, np.nan)

    def fixed(
        self, cloud: PointCloud, selected: npt.NDArray[np.bool_] | None, first: int = 0
    ) -> npt.NDArray[np.bool_] | None:
        """Tell which rows stay if they take part, (n,); None if nothing says so.

        `first` is the row of the file that is the first of these, for messages.
        """
        fixed = None
        if self.moves:
            fixed = fixed_points(cloud, self.fixed_column, self.path, first)
        if selected is None:
            return fixed
        return ~selected if fixed is None else fixed | ~selected

    def usable(self, cloud: PointCloud) -> npt.NDArray[np.bool_]:
        """Tell which rows take part, (n,): finite ones of these."""
        selected = self.selected(cloud) if self.ignores_others else None
        return usable_rows(self.positions(cloud, selected))

    def check_selected(self, counts: PointCounts) -> None:
        """Raise `CloudFileError` if no point takes part since none is selected."""
        if self.selection is not None and counts.ignored and not counts.selected:
            missed = self.selection.missed_in_words(counts.box, counts.noise)
            raise CloudFileError(self.path, missed, "select points of it")

    @property
    def provenance(self) -> str:
        """Say for a comment what is selected."""
        return "" if self.selection is None else self.selection.provenance

    @property
    def ignores_others(self) -> bool:
        """Whether points that are not selected take no part."""
        return self.selection is not None and self.selection.ignores_others

    @property
    def needs_columns(self) -> bool:
        """Whether positions alone do not tell which points take part."""
        selection = self.selection
        return selection is not None and selection.ignores_others and selection.where is not None


@dataclass
class PointCounts:
    """How many points of a file take part in what way, as far as rows have been added.

    Attributes
    ----------
    noise : int
        Those that the file calls noise, and that take no part.
    selected : int
        Of those that are finite and no noise, if there is a selection.
    ignored : int
        Of these, such as take no part since they are not selected.
    box : ndarray, shape (2, d), or None
        Corners of their bounding box, L; None before there is one.
    """

    noise: int = 0
    selected: int = 0
    ignored: int = 0
    box: npt.NDArray[np.float64] | None = None

    def add(
        self, cloud: PointCloud, selected: npt.NDArray[np.bool_] | None, ignores_others: bool
    ) -> None:
        """Add some rows of the file, of which these are selected, (n,)."""
        self.noise += cloud.noise_count
        if selected is None:
            return
        usable = usable_rows(cloud.active_points)
        chosen = selected[usable]
        self.selected += int(np.count_nonzero(chosen))
        if ignores_others:
            self.ignored += int(np.count_nonzero(~chosen))
        points = cloud.points[usable]
        if len(points):
            corners = points if self.box is None else np.concatenate([points, self.box])
            self.box = np.stack([corners.min(axis=0), corners.max(axis=0)])
