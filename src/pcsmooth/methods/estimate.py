"""How normals and curvatures are estimated, as it is asked for."""

from __future__ import annotations

from dataclasses import dataclass

from pcsmooth.curvature.orientation import Orientation, parse_orientation
from pcsmooth.curvature.support import Support, check_support


@dataclass(frozen=True)
class Estimate:
    """How normals and curvatures are estimated (see `estimate_curvature`).

    Attributes
    ----------
    support : int or "auto"
        Points of the neighbourhoods in which curvatures are fitted.
    orient : str
        Which way normals point: ``"auto"``, ``"outward"``, ``"propagate"``, ``"input"``,
        ``"viewpoint=X,Y,Z"`` or ``"direction=X,Y,Z"``.

    Raises
    ------
    InvalidInputError
        A value is none of these.
    """

    support: Support = "auto"
    orient: str = "auto"

    def __post_init__(self) -> None:
        """Check the values."""
        check_support(self.support)
        parse_orientation(self.orient)

    @property
    def orientation(self) -> Orientation:
        """The rule that `orient` names."""
        return parse_orientation(self.orient)
