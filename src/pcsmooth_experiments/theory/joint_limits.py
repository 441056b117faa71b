"""How the radius follows as a sample becomes dense."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class JointLimit:
    """A rule by which the radius falls with the covering radius of the sample.

    Attributes
    ----------
    name : str
        In tables and pictures.
    power : float
        The radius goes as epsilon to this power: 0 keeps it fixed, 1 keeps epsilon / r fixed, 1/2
        makes epsilon / r fall as r.
    """

    name: str
    power: float

    @property
    def is_fixed(self) -> bool:
        """Whether the radius does not change."""
        return self.power == 0.0

    def radius(self, covering: float, first_covering: float, first_radius: float) -> float:
        """Radius for a covering radius, given both of the coarsest sample, L."""
        return float(first_radius * (covering / first_covering) ** self.power)


FIXED_RADIUS = JointLimit("r fixed", 0.0)
FIXED_RATIO = JointLimit("eps/r fixed", 1.0)
RATIO_AS_RADIUS = JointLimit("eps ~ r^2", 1.0 / 2.0)
RATIO_AS_SQUARE = JointLimit("eps ~ r^3", 1.0 / 3.0)
