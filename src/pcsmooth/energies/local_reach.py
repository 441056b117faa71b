"""How far the measures of balls of local radius depend on points, part by part."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.neighbors.grid import UNEQUAL_CUBE_LEVEL
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.neighbors.local_spacing import SLOPE

#: Cells are at most so many times as wide as their points look far: see `levels_of`.
_CELL = 2.0 * (1.0 + 1e-5)


@dataclass(frozen=True, eq=False)
class LocalReach:
    """How far cells, normals and links look from the points of each part (see `Reach`).

    Attributes
    ----------
    local : LocalRadii
        The radii.
    dimension : int
        d.
    beyond : float
        What is looked farther than that, L.

    Notes
    -----
    Large balls are felt farther than small ones. How large the balls are around a part is known
    from its cubes, so that a part looks as far as those ask for that come near it, one after the
    other: what links of its own points lead to; the blocks in which these are joined; the points
    whose cells give normals there; the blocks of cells of these; what touches all of them.
    """

    local: LocalRadii
    dimension: int
    beyond: float = 0.0

    def __add__(self, length: float) -> LocalReach:
        """Look farther by a length, L."""
        return replace(self, beyond=self.beyond + length)

    def of_parts(self, drift: float) -> npt.NDArray[np.float64]:
        """Tell it of all parts, along an axis, L."""
        at = _AroundParts(self.local, drift)
        block = float(1 << UNEQUAL_CUBE_LEVEL[self.dimension])

        def blocks(within: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
            """Go as far as what shares a block with points so far off."""
            return within + block * _CELL * at.touching(within)

        # From the own points to the points and blocks that their links lead to.
        linked = blocks(2.0 * at.radius(at.nothing))
        # Normals of those: by what shares their cells, and by the points around.
        normals = linked + _CELL * at.touching(linked)
        cells = blocks(normals + 2.0 * at.radius(normals))
        # All cells around those are complete, and it is known how far their points look.
        touching = at.touching(cells)
        return cells + np.maximum(_CELL * touching, at.partner(cells)) + self.beyond


@dataclass(frozen=True, eq=False)
class _AroundParts:
    """How large balls are around parts, by distances (n_parts,), L, after some drift, L."""

    local: LocalRadii
    drift: float

    @property
    def nothing(self) -> npt.NDArray[np.float64]:
        """No distance, for each part."""
        return np.zeros(self.local.around.n_parts)

    def radius(self, within: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Largest radius."""
        return self.local.multiple * self.local.around(within + 2.0 * self.drift)

    def partner(self, within: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """How far off the ball may be that touches one of the balls there.

        Radii r rose by no more than a slope s < 1 times the distance when points were at their
        start, so that r + s (d + 2 drift) + r >= d.
        """
        radii = self.radius(within)
        farthest = radii + self.local.largest
        slope = SLOPE * self.local.multiple
        if slope >= 1.0:
            return farthest
        nearer = (2.0 * radii + 2.0 * slope * self.drift) / (1.0 - slope)
        return np.asarray(np.minimum(farthest, nearer))

    def touching(self, within: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """How far the points there look: as far as the balls that touch theirs."""
        return self.radius(within) + self.radius(within + self.partner(within))
