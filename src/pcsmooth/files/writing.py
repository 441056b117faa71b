"""How estimates are to be written, as it is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from pcsmooth.errors import InvalidInputError
from pcsmooth.files.output_columns import Convention, Dialect

#: Columns that are written where they are asked for.
EXTRA_COLUMNS = ("spacing", "sigma", "sigma_after")

#: Of these, what only a filter finds.
_OF_FILTERS = ("sigma", "sigma_after")

Outliers = Literal["mark", "remove", "only", "class"]
"""What becomes of outliers: a column marks them, their rows are left out, or all others, or their
classification in LAS says it."""


@dataclass(frozen=True)
class Writing:
    """How estimates are to be written.

    Attributes
    ----------
    convention : {"half", "sum"}
        Which mean curvature.
    dialect : {"generic", "meshlab", "cloudcompare", "pcl"}
        Which program the columns of a PLY file are for.
    colormap : str or None
        Color map, None for no colors.
    color_by : {"mean", "gaussian", "k1", "k2", "confidence"}
        The estimate shown in colors.
    single : bool or None
        Whether positions are float; None leaves it to input and dialect. LAS has its steps.
    extra_columns : tuple of str
        What is written besides: ``"spacing"``, the local spacing at the positions written (see
        `local_spacings`); ``"sigma"``, the standard deviation of the noise that the filter found of
        each point of the input; ``"sigma_after"``, that of the error that it leaves.
    displacement : bool
        Whether each point's way from the input is written as a vector, in columns dx dy dz (in 2D
        dx dy) of double precision: the position in the file plus this is that of the input.
    outliers : {"mark", "remove", "only", "class"}
        Whether a column marks the outliers that a filter found, or they are left out of the file,
        or all other points are, or they get a noise class of LAS: 18 above the surface, else 7.
        Fixed points are never left out as outliers, and keep their class.
    """

    convention: Convention = "half"
    dialect: Dialect = "generic"
    colormap: str | None = None
    color_by: str = "mean"
    single: bool | None = None
    extra_columns: tuple[str, ...] = ()
    displacement: bool = False
    outliers: Outliers = "mark"

    def __post_init__(self) -> None:
        """Check what was asked for."""
        for name in self.extra_columns:
            if name not in EXTRA_COLUMNS:
                raise InvalidInputError(
                    f"extra column {name!r} is not known; there is {', '.join(EXTRA_COLUMNS)}"
                )
        if self.outliers not in get_args(Outliers):
            raise InvalidInputError(
                f"outliers {self.outliers!r} is not known; there is {', '.join(get_args(Outliers))}"
            )

    def check_moved_by(self, scheme: str) -> None:
        """Check that what is written is found by a scheme, "" if no point moves.

        Raises
        ------
        InvalidInputError
            If it is not.
        """
        if self.displacement and not scheme:
            raise InvalidInputError("a run that moves no point has no displacement: leave it out")
        if scheme == "filter":
            return
        by = f"the scheme {scheme}" if scheme else "a run that moves no point"
        if self.outliers != "mark":
            raise InvalidInputError(
                f"outliers are found by the filter, and {by} does not look for them: leave out "
                f"--outliers {self.outliers}"
            )
        found = [name for name in self.extra_columns if name in _OF_FILTERS]
        if found:
            raise InvalidInputError(
                f"the column {found[0]} is of the noise that the filter finds, and {by} does not "
                "look for it: leave it out"
            )

    @property
    def whole_cloud_for(self) -> str:
        """Name what of it needs the whole cloud; nothing if it can be done in parts."""
        return "the column spacing" if "spacing" in self.extra_columns else ""
