"""Which side of a closed surface is outside, as far as the noise lets it be seen."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.winding_field import (
    MOST_CELLS,
    WindingField,
    find_winding_field,
    lattice_step,
)
from pcsmooth.filters.design import FilterDesign
from pcsmooth.filters.strays import leave_out_strays
from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.neighbors.surroundings import look_around
from pcsmooth.parts.part import Parts

#: Cells along each side of the lattice, at least. With 28 errors on a sphere whose noise is a tenth
#: of its radius are up to three times as large as without sides.
_FEWEST_CELLS = 32


@dataclass(frozen=True, eq=False)
class Sides:
    """Points of a closed surface from which is found which side is outside.

    Attributes
    ----------
    points : ndarray, shape (m, d)
        L.
    areas : ndarray, shape (m,)
        How much of the surface each stands for, in any unit.
    extent : float
        Of the cloud, L.
    design : FilterDesign
        Numbers to go by.
    """

    points: npt.NDArray[np.float64]
    areas: npt.NDArray[np.float64]
    extent: float
    design: FilterDesign
    _found: dict[int, WindingField] = field(default_factory=dict, init=False)

    def seen_through(self, noise: float, *, is_known: bool) -> WindingField | None:
        """Find the sides through a noise, L; None where it is too small or too large for a lattice.

        Steps of the lattice are as small as the noise lets them be: within it a surface has no
        sides. But noise that is not known may be taken for so much that thin parts are within it:
        then steps are as small as can be.
        """
        design = self.design
        if lattice_step(self.extent, MOST_CELLS) > design.sides_noise * noise:
            return None
        wanted = int(lattice_step(self.extent, 1.0) / (design.sides_step * noise))
        if is_known and wanted < _FEWEST_CELLS:
            return None
        cells = min(MOST_CELLS, wanted) if is_known else MOST_CELLS
        if cells not in self._found:
            self._found[cells] = find_winding_field(self.points, self.areas, cells)
        return self._found[cells].smoothed(design.sides_width * noise)


def look_at_sides(
    parts: Parts, distinct: Distinct, is_crowded: bool, extent: float, design: FilterDesign
) -> Sides:
    """Take points of a cloud at its start, to find out which side of its surface is outside.

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position.
    is_crowded : bool
        Whether outliers are to be left out.
    extent : float
        Of the cloud, L.
    design : FilterDesign
        Numbers to go by.

    Returns
    -------
    Sides
    """
    nearest = design.sides_nearest
    around = look_around(parts, distinct, "noise", design.sides_samples, nearest, nearest)
    if is_crowded:
        around = leave_out_strays(around, design)
    points = np.ascontiguousarray(around.positions[:, 0])
    areas = around.distances[:, -1] ** (parts.dimension - 1)
    return Sides(points, areas, extent, design)
