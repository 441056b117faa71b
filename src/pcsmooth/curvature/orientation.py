"""Where normals should point: the rules, and how they are written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.positions import LARGEST

Rule = Literal["auto", "outward", "propagate", "input", "viewpoint", "direction"]

#: Rules that need a vector.
_WITH_VECTOR = ("viewpoint", "direction")


@dataclass(frozen=True)
class Orientation:
    """Where normals should point.

    Attributes
    ----------
    rule : str
        auto, outward, propagate, input, viewpoint or direction: see `find_oriented_normals`.
    vector : tuple of float, optional
        The viewpoint, L, or the direction.
    """

    rule: Rule = "auto"
    vector: tuple[float, ...] | None = None

    def seen_from(self, origin: npt.NDArray[np.float64], unit: float = 1.0) -> Orientation:
        """Return the same rule in a frame whose origin lies elsewhere, in another unit, L."""
        if self.rule != "viewpoint":
            return self
        vector = (self.vector_in(len(origin)) - origin) / unit
        return Orientation(self.rule, tuple(vector.tolist()))

    def vector_in(self, dimension: int) -> npt.NDArray[np.float64]:
        """Return the vector, (d,).

        Raises
        ------
        InvalidInputError
            If it has another dimension.
        """
        vector = np.asarray(self.vector, np.float64)
        if vector.shape != (dimension,):
            raise InvalidInputError(
                f"the {self.rule} has {vector.size} coordinates and the points {dimension}; "
                "give as many as the points have"
            )
        return vector


def parse_orientation(text: str) -> Orientation:
    """Read auto, outward, propagate, input, viewpoint=X,Y,Z or direction=X,Y,Z.

    Raises
    ------
    InvalidInputError
        If it is none of these, or the numbers are not finite, or a direction is zero.
    """
    name, separator, numbers = str(text).strip().partition("=")
    for rule in get_args(Rule):
        if name != rule or (rule in _WITH_VECTOR) != bool(separator):
            continue
        if not separator:
            return Orientation(rule)
        try:
            vector = tuple(float(number) for number in numbers.split(","))
        except ValueError:
            break
        is_usable = all(abs(number) <= LARGEST for number in vector) and len(vector) in (2, 3)
        if is_usable and (rule == "viewpoint" or any(vector)):
            return Orientation(rule, vector)
    raise InvalidInputError(
        f"orientation is {text!r}; it must be auto, outward, propagate, input, viewpoint=X,Y,Z "
        "or direction=X,Y,Z with finite numbers, the direction not zero"
    )
