"""How points may move, as it is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

from pcsmooth.flows.restraint import Restraint
from pcsmooth.lengths import check_length
from pcsmooth.measured import Measured
from pcsmooth.methods.checks import check_share, check_word

Direction = Literal["free", "normal"]


@dataclass(frozen=True)
class Motion:
    """What restrains the motion of points, whatever the method that moves them.

    Attributes
    ----------
    direction : {"free", "normal"}
        Whether points go where the method takes them or along their normals only. The filter then
        leaves out its step along the surface.
    max_move : float or str, optional
        Most that a point may move in all: a length, ``"0.5x"`` the spacing, or ``"1%"`` of the
        bounding box's diagonal.
    keep_volume : bool
        Take the mean normal displacement of each connected component out of each step.
    strength : float
        Share of its way, from 0 to 1, that each point goes in the end, when all else is done.

    Raises
    ------
    InvalidInputError
        A value is none of these.
    """

    direction: Direction = "free"
    max_move: float | str | None = None
    keep_volume: bool = False
    strength: float = 1.0

    def __post_init__(self) -> None:
        """Check the values."""
        check_word("motion", self.direction, get_args(Direction))
        if self.max_move is not None:
            check_length(self.max_move, "max_move")
        check_share("strength", self.strength)

    def on(self, cloud: Measured) -> Motion:
        """Say it of a cloud: with lengths in the unit of the input."""
        if self.max_move is None:
            return self
        return replace(self, max_move=cloud.length(self.max_move, "max_move") * cloud.unit)

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
            self.direction == "normal" and not moves_along_normals,
            self.keep_volume,
            math.inf if self.max_move is None else cloud.length(self.max_move, "max_move"),
        )
