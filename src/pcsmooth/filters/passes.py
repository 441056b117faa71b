"""The passes of the filter, and its last step."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.neighborhoods import Neighborhoods, find_neighborhoods
from pcsmooth.filters.plan import FilterPlan

#: Exponents of the neighbours' weights in each pass and in the last step: normals are known
#: better and better.
_PASS_EXPONENTS = (2, 4, 4)
_LAST_EXPONENT = 8

#: Exponent of the neighbours' weights where outliers are looked for.
OUTLIERS_EXPONENT = _PASS_EXPONENTS[0]

#: Passes in all.
N_PASSES = len(_PASS_EXPONENTS) + 1

#: Exponent of the weights with which the normals of a pass are averaged.
_NORMALS_EXPONENT = 4

#: Reaches of the neighbourhoods, on end, within which a point depends on others. In a pass: heights
#: are averaged, which are means over the averaged normals around, these over those of the planes,
#: and these lie through the points around. In the last step: energies, residuals, heights, planes.
PASS_REACHES = 4
LAST_REACHES = 4

#: Most that a point ends up away from its start, in units of the noise: real noise has long tails,
#: and is larger in places.
LONGEST = 6.0

#: Variance that the passes leave on a smooth surface, in units of the noise's over the points of
#: a neighbourhood: 0.93 to 1.03 on spheres with noise of 0.2 to 1.4 spacings, 0.97 to 1.26 on
#: circles, and a margin, because energies are means over few points.
_LEFT = 1.2

#: Share of a neighbourhood's area over which the energy of residuals is averaged.
_ENERGY_SHARE = 0.5


def take_pass(
    start: npt.NDArray[np.float64],
    points: npt.NDArray[np.float64],
    plan: FilterPlan,
    number: int,
    held: npt.NDArray[np.bool_],
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Take one of the first passes.

    Parameters
    ----------
    start : ndarray, shape (n, d)
        Where the points that take part were before the filter, L.
    points : ndarray, shape (n, d)
        Where they are, L.
    plan : FilterPlan
        Of the filter.
    number : int
        Which pass, from 0.
    held : ndarray of bool, shape (n,)
        Points that do not move.

    Returns
    -------
    points : ndarray, shape (n, d)
        New positions. Each depends on the points within `PASS_REACHES` reaches of it.
    sizes : ndarray, shape (n,)
        Points of the neighbourhoods.
    """
    exponent = _PASS_EXPONENTS[number]
    hoods = find_neighborhoods(points, plan.passes[number])
    hoods = hoods.with_averaged_normals(_NORMALS_EXPONENT)
    moved = _moved(points, hoods, _residuals(hoods, exponent), held)
    return _not_far(start, moved, LONGEST * plan.noise.deviation), hoods.in_order(hoods.sizes)


def take_last_step(
    start: npt.NDArray[np.float64],
    points: npt.NDArray[np.float64],
    plan: FilterPlan,
    held: npt.NDArray[np.bool_],
    sizes: npt.NDArray[np.float64],
) -> npt.NDArray[np.float64]:
    """Take the last step.

    Parameters
    ----------
    start, points, plan, held
        As `take_pass` has them.
    sizes : ndarray, shape (n,)
        Points of the neighbourhoods in the last of the passes.

    Returns
    -------
    ndarray, shape (n, d)
        New positions. Each depends on the points within `LAST_REACHES` reaches of it.
    """
    noise = plan.noise.deviation
    hoods = find_neighborhoods(points, plan.last)
    residuals = _residuals(hoods, _LAST_EXPONENT)
    energies = hoods.means(residuals * residuals, _LAST_EXPONENT, _ENERGY_SHARE)
    left = _LEFT * noise * noise / sizes[hoods.grid.order]
    shares = np.divide(left, energies, out=np.ones_like(left), where=energies > left)
    moved = _moved(points, hoods, shares * shares * residuals, held)
    return _not_far(start, moved, LONGEST * noise)


def _residuals(hoods: Neighborhoods, exponent: int) -> npt.NDArray[np.float64]:
    """How far along its normal each point is to move, (n,), L, in grid order."""
    heights = hoods.heights(exponent)
    return heights - hoods.means_along_normals(heights, exponent)


def _moved(
    points: npt.NDArray[np.float64],
    hoods: Neighborhoods,
    lengths: npt.NDArray[np.float64],
    held: npt.NDArray[np.bool_],
) -> npt.NDArray[np.float64]:
    """Move points along their normals, those that are held not."""
    order = hoods.grid.order
    lengths = np.where(held[order], 0.0, lengths)
    moved = points.copy()
    moved[order] += (lengths * hoods.normals[: hoods.dimension]).T
    return moved


def _not_far(
    start: npt.NDArray[np.float64], points: npt.NDArray[np.float64], longest: float
) -> npt.NDArray[np.float64]:
    """Bring points that are farther than the longest way from their start back to that."""
    way = points - start
    lengths = np.sqrt(np.einsum("ij,ij->i", way, way))
    far = lengths > longest
    way[far] *= (longest / lengths[far])[:, np.newaxis]
    return start + way
