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


@dataclass(frozen=True, eq=False)
class Sides:
    """Points of a closed surface from which is found which side is outside.

    Attributes
    ----------
    points : ndarray, shape (m, d)
        L.
    areas : ndarray, shape (m,)
        How much of the surface each stands for, in any unit.
    design : FilterDesign
        Numbers to go by.
    """

    points: npt.NDArray[np.float64]
    areas: npt.NDArray[np.float64]
    design: FilterDesign
    _found: dict[int, WindingField] = field(default_factory=dict, init=False)

    def seen_through(self, noise: float, *, is_known: bool) -> WindingField | None:
        """Find the sides through a noise, L; None where it is too small or too large for a lattice.

        Steps of the lattice are as small as the noise lets them be: within it a surface has no
        sides. But noise that is not known may be taken for so much that thin parts are within it:
        then steps are as small as can be.
        """
        design = self.design
        extent = float(np.ptp(self.points, axis=0).max())
        if lattice_step(extent, MOST_CELLS) > design.sides_noise * noise:
            return None
        wanted = int(lattice_step(extent, 1.0) / (design.sides_step * noise))
        if is_known and wanted < design.sides_cells:
            return None
        cells = min(MOST_CELLS, wanted) if is_known else MOST_CELLS
        if cells not in self._found:
            self._found[cells] = find_winding_field(self.points, self.areas, cells)
        return self._found[cells].smoothed(design.sides_width * noise)


def look_at_sides(
    parts: Parts, distinct: Distinct, is_crowded: bool, design: FilterDesign
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
    design : FilterDesign
        Numbers to go by.

    Returns
    -------
    Sides
        Of few points that are far from all others none, as the lattice would reach there.
    """
    nearest = design.sides_nearest
    around = look_around(parts, distinct, "noise", design.sides_samples, nearest, nearest)
    if is_crowded:
        around = leave_out_strays(around, design)
    points, widths = around.positions[:, 0], around.distances[:, -1]
    is_near = widths <= design.sides_far * np.median(widths)
    if np.count_nonzero(~is_near) <= design.sides_few * len(points):
        points, widths = points[is_near], widths[is_near]
    return Sides(np.ascontiguousarray(points), widths ** (parts.dimension - 1), design)
