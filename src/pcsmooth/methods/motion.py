"""How points may move, as it is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.flows.restraint import Restraint
from pcsmooth.lengths import check_length
from pcsmooth.measured import Measured
from pcsmooth.methods.checks import check_numbers, check_share, check_word

Floats = npt.NDArray[np.float64]

Direction = Literal["free", "normal", "ray"]


@dataclass(frozen=True)
class Motion:
    """What restrains the motion of points, whatever the method that moves them.

    Attributes
    ----------
    direction : {"free", "normal", "ray"}
        Whether points go where the method takes them, along their normals only, or along the beams
        that saw them (see `go_along_beams`). With the latter two the filter leaves out its step
        along the surface.
    max_move : float or str, optional
        Most that a point may move in all: a length, ``"0.5x"`` the spacing, or ``"1%"`` of the
        bounding box's diagonal.
    keep_volume : bool
        Take the mean normal displacement of each connected component out of each step.
    strength : float
        Share of its way, from 0 to 1, that each point goes in the end, when all else is done.
    origin : tuple of float, optional
        Where the beams come from, L; for "ray", and needed there.

    Raises
    ------
    InvalidInputError
        A value is none of these.
    """

    direction: Direction = "free"
    max_move: float | str | None = None
    keep_volume: bool = False
    strength: float = 1.0
    origin: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        check_word("motion", self.direction, get_args(Direction))
        if self.max_move is not None:
            check_length(self.max_move, "max_move")
        check_share("strength", self.strength)
        if self.origin is not None:
            check_numbers("origin", self.origin)
        if (self.direction == "ray") != (self.origin is not None):
            raise InvalidInputError(
                "motion is 'ray', which needs the origin of the beams; give origin"
                if self.origin is None
                else f"origin is given and motion is {self.direction!r}; choose motion 'ray'"
            )

    def on(self, cloud: Measured) -> Motion:
        """Say it of a cloud: with lengths in the unit of the input."""
        if self.max_move is None:
            return self
        return replace(self, max_move=cloud.length(self.max_move, "max_move") * cloud.unit)

    def origin_seen_from(self, place: Floats, unit: float) -> Floats | None:
        """Give the origin of the beams in a frame whose own lies elsewhere, in another unit, L.

        Raises
        ------
        InvalidInputError
            It has another dimension.
        """
        if self.origin is None:
            return None
        if len(self.origin) != len(place):
            raise InvalidInputError(
                f"the origin has {len(self.origin)} coordinates and the points {len(place)}; "
                "give as many as the points have"
            )
        return np.asarray((np.array(self.origin) - place) / unit)

    def restraint(self, cloud: Measured, *, moves_along_normals: bool) -> Restraint:
        """Make what restrains displacements, in the cloud's unit.

        Parameters
        ----------
        cloud : Measured
            Size and spacing of the cloud.
        moves_along_normals : bool
            Whether the method does that by itself, if it is to.
        """
        return Restraint(
            self.direction != "free" and not moves_along_normals,
            self.keep_volume,
            math.inf if self.max_move is None else cloud.length(self.max_move, "max_move"),
        )
