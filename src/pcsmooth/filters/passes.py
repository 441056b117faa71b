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

#: Largest radii of the neighbourhoods, on end, within which a point depends on others. In a pass:
#: heights are averaged, which are means over the averaged normals around, these over those of the
#: planes, and these lie through the points around. In the last step: energies, residuals, heights,
#: planes.
PASS_REACHES = 4
LAST_REACHES = 4

#: Most that a point ends up away from its start, in units of the noise: real noise has long tails,
#: and is larger in places.
MAX_MOVE = 6.0

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
    fixed: npt.NDArray[np.bool_],
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
    fixed : ndarray of bool, shape (n,)
        Points that do not move.

    Returns
    -------
    points : ndarray, shape (n, d)
        New positions. Each depends on the points within `PASS_REACHES` largest radii of it.
    sizes : ndarray, shape (n,)
        Points of the neighbourhoods.
    """
    exponent = _PASS_EXPONENTS[number]
    neighborhoods = find_neighborhoods(points, plan.passes[number])
    neighborhoods = neighborhoods.with_averaged_normals(_NORMALS_EXPONENT)
    moved = _moved(points, neighborhoods, _residuals(neighborhoods, exponent), fixed)
    return _limited(start, moved, MAX_MOVE * plan.noise.deviation), neighborhoods.in_order(
        neighborhoods.sizes
    )


def take_last_step(
    start: npt.NDArray[np.float64],
    points: npt.NDArray[np.float64],
    plan: FilterPlan,
    fixed: npt.NDArray[np.bool_],
    sizes: npt.NDArray[np.float64],
) -> npt.NDArray[np.float64]:
    """Take the last step.

    Parameters
    ----------
    start, points, plan, fixed
        As `take_pass` has them.
    sizes : ndarray, shape (n,)
        Points of the neighbourhoods in the last of the passes.

    Returns
    -------
    ndarray, shape (n, d)
        New positions. Each depends on the points within `LAST_REACHES` largest radii of it.
    """
    noise = plan.noise.deviation
    neighborhoods = find_neighborhoods(points, plan.last)
    residuals = _residuals(neighborhoods, _LAST_EXPONENT)
    energies = neighborhoods.means(residuals * residuals, _LAST_EXPONENT, _ENERGY_SHARE)
    left = _LEFT * noise * noise / sizes[neighborhoods.grid.order]
    shares = np.divide(left, energies, out=np.ones_like(left), where=energies > left)
    moved = _moved(points, neighborhoods, shares * shares * residuals, fixed)
    return _limited(start, moved, MAX_MOVE * noise)


def _residuals(neighborhoods: Neighborhoods, exponent: int) -> npt.NDArray[np.float64]:
    """How far along its normal each point is to move, (n,), L, in grid order."""
    heights = neighborhoods.heights(exponent)
    return heights - neighborhoods.means_along_normals(heights, exponent)


def _moved(
    points: npt.NDArray[np.float64],
    neighborhoods: Neighborhoods,
    lengths: npt.NDArray[np.float64],
    fixed: npt.NDArray[np.bool_],
) -> npt.NDArray[np.float64]:
    """Move points along their normals, those that are fixed not."""
    order = neighborhoods.grid.order
    lengths = np.where(fixed[order], 0.0, lengths)
    moved = points.copy()
    moved[order] += (lengths * neighborhoods.normals[: neighborhoods.dimension]).T
    return moved


def _limited(
    start: npt.NDArray[np.float64], points: npt.NDArray[np.float64], max_move: float
) -> npt.NDArray[np.float64]:
    """Bring points that are farther than that from their start back to it."""
    way = points - start
    lengths = np.sqrt(np.einsum("ij,ij->i", way, way))
    far = lengths > max_move
    way[far] *= (max_move / lengths[far])[:, np.newaxis]
    return start + way
