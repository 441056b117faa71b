"""The filter of a cloud: passes, evening, and a last step as strong as the surface allows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.evening import even_out
from pcsmooth.filters.neighborhoods import Neighborhoods, find_neighborhoods
from pcsmooth.filters.outliers import find_outliers
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


@dataclass(frozen=True)
class Filtered:
    """A filtered cloud.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        New positions, L.
    outliers : ndarray of bool, shape (n,)
        Points too far from all others, or from the surface of those around, which stay where
        they are.
    """

    points: npt.NDArray[np.float64]
    outliers: npt.NDArray[np.bool_]


def filter_points(
    points: npt.NDArray[np.float64],
    plan: FilterPlan | None,
    held: npt.NDArray[np.bool_],
    *,
    evens: bool = True,
    on_pass: Callable[[], None] | None = None,
) -> Filtered:
    """Take the noise out of a cloud.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite, distinct positions, L.
    plan : FilterPlan or None
        What `plan_filter` chose for these points.
    held : ndarray of bool, shape (n,)
        Points that do not move, and act on the others.
    evens : bool
        Whether points also move along the surface, to be spread more evenly.
    on_pass : callable, optional
        Called after each of the `N_PASSES` passes, of which the last step is one.

    Returns
    -------
    Filtered

    Notes
    -----
    A pass moves every point along its normal by z_i - mean_j(z_j), z_i the mean height of its
    neighbours over its tangent plane, and the mean of the z_j as lengths along their normals:
    Tukey's twicing, 2 W - W^2 for the averaging W. Plain averaging moves the points of a curved
    surface by r^2 H / 4; that is the same for all neighbours, and cancels. What is left is of
    fourth order in the radius, as in surface diffusion. Neighbours weigh |n_i . n_j|^e.

    Neighbourhoods are as wide as the noise needs (see `Width`): with a sheet thicker than the
    spacing, smaller ones are balls within it that know no surface. Between the passes and the
    last step the points are spread evenly (see `even_out`).

    The last step does the same with neighbourhoods of ten times as many points, but takes only a
    share of it. Its residual consists of the noise v that the passes have left, v = 1.2 sigma^2 /
    N, and of the surface's own detail. From their common energy r = mean(residual^2) around a
    point the share is min(1, v / r)^2 (Wiener's filter has v / r): all of it where the surface
    is smooth, next to nothing at edges and detail.

    No point ends up farther from its start than six times the noise. Points that fill a volume,
    of which no surface shows, stay.
    """
    if plan is None or not plan.moves_points:
        return Filtered(points, np.zeros(len(points), np.bool_))
    noise = plan.noise.deviation
    outliers = find_outliers(points, plan.passes[0], noise, OUTLIERS_EXPONENT)
    taking_part = np.flatnonzero(~outliers)
    if taking_part.size == 0:
        return Filtered(points, outliers)
    start, still = points[taking_part], held[taking_part]
    now = start
    tell = on_pass if on_pass is not None else lambda: None
    sizes = np.empty(0)
    for number in range(len(plan.passes)):
        now, sizes = take_pass(start, now, plan, number, still)
        tell()
    if evens:
        now = even_out(now, plan.passes[-1], noise, still)
    now = take_last_step(start, now, plan, still, sizes)
    tell()
    result = points.copy()
    result[taking_part] = now
    return Filtered(result, outliers)


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
