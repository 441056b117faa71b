"""A pilot: what the passes of the filter take from pieces of a cloud tells the noise better."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.filters import passes
from pcsmooth.filters.design import FilterDesign
from pcsmooth.filters.neighborhoods import find_neighborhoods
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.neighbors.k_nearest import k_nearest
from pcsmooth.neighbors.marked import marked_rows
from pcsmooth.neighbors.surroundings import look_around
from pcsmooth.parts.part import Parts

#: Median of the absolute difference of two numbers with a standard deviation of 1.
_MEDIAN_DIFFERENCE = 0.6744897501960817 * math.sqrt(2.0)


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces of a cloud, side by side, too far from each other to touch.

    Attributes
    ----------
    points : ndarray, shape (m, d)
        Their points, L.
    inner : ndarray of int, shape (k,)
        Which of them have all points around them that they depend on, or nearly all.
    is_whole : bool
        Whether they are one piece, the whole cloud where it is.
    """

    points: npt.NDArray[np.float64]
    inner: npt.NDArray[np.int64]
    is_whole: bool


def cut_pieces(parts: Parts, distinct: Distinct, plan: FilterPlan, design: FilterDesign) -> Pieces:
    """Cut pieces from a cloud at its start, so large that a filter shows what it does to clouds.

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position.
    plan : FilterPlan
        Tells how wide neighbourhoods are, at most.
    design : FilterDesign
        Numbers to go by.

    Returns
    -------
    Pieces
        The whole cloud if it is small.
    """
    count, dimension = distinct.count, parts.dimension
    if count <= design.pilot_points:
        rows = marked_rows(distinct.marks, np.arange(count))
        return Pieces(parts.start.take(rows), np.arange(count), is_whole=True)
    widened = design.pilot_width ** (dimension - 1)
    size = math.ceil(min(max(widened * plan.support, design.pilot_least), design.pilot_most))
    around = look_around(parts, distinct, "noise", design.pilot_points // size, size, size)
    # Pieces around strays would hold few points of a surface, and lie far from the others.
    extents = around.distances[:, -1]
    near = extents <= design.pilot_max_extent * np.median(extents)
    positions, distances = around.positions[near], around.distances[near]
    centers, farthest = positions[:, :1], distances[:, -1:]
    widest = plan.passes[0].max_radius
    # As far from each other as no neighbourhood reaches.
    steps = np.zeros(dimension)
    steps[0] = 2.0 * (float(farthest.max()) + widest)
    numbers = np.arange(len(centers))[:, np.newaxis, np.newaxis]
    points = positions - centers + numbers * steps
    inner = distances <= np.maximum(farthest - 2.0 * widest, farthest / 3.0)
    return Pieces(points.reshape(-1, dimension), np.flatnonzero(inner), is_whole=False)


@dataclass(frozen=True)
class Trial:
    """What a filter does that is told some noise.

    Attributes
    ----------
    taken : float
        Noise that it takes, L.
    support : float
        Points of its neighbourhoods, at the median.
    """

    taken: float
    support: float


def correct_noise(
    found: float,
    try_filter: Callable[[float], Trial],
    design: FilterDesign,
    *,
    sides_are_apart: bool = False,
) -> float:
    """Correct the noise of a cloud by what filters take that are told so much, or less.

    Parameters
    ----------
    found : float
        What was measured, L, > 0: too much where the surface has detail, or two sides that are near
        each other.
    try_filter : callable
        Tries a filter that is told a noise, L.
    design : FilterDesign
        Numbers to go by.
    sides_are_apart : bool
        Whether the filter tells both sides of thin parts apart.

    Returns
    -------
    float
        Standard deviation of the noise, L.

    Notes
    -----
    A filter that is told too much merges the sides of thin walls and takes detail for noise: what
    it takes falls as steeply as what it is told, or more. One that is told less than there is takes
    no more than it is told. Between them is a plateau, where it takes about the noise whatever it
    is told. Less is tried step by step until that is reached. There what is taken is too little
    where the filter has followed the noise, and what is told too much: the noise is their geometric
    mean, where what is told is no more than 4/3 of what is taken.

    Where there is no plateau what was measured is kept: what is taken has fallen to the end, as
    where a surface bends by more than its noise from point to point and the shares of the passes
    follow what is told, or it has followed what is told all the way.

    Where noise is twice the spacing or more neighbourhoods are so full that a filter that is told a
    little less than there is leaves much of it: the plateau is a peak. What is told is then kept
    unless what is taken falls even more steeply, or sides are told apart: how full neighbourhoods
    are says nothing then, as what was measured may be the thickness of the parts.
    """
    told, trial = found, try_filter(found)
    for _ in range(design.pilot_steps):
        less = told * design.pilot_step
        then = try_filter(less)
        slope = design.pilot_slope * max(1.0, trial.support / design.pilot_support)
        if not 0.0 < then.taken < trial.taken * design.pilot_step**slope:
            trial = replace(trial, taken=max(trial.taken, then.taken))
            break
        told, trial = less, then
    else:
        return found
    if told < found and trial.taken > design.pilot_share * told:
        return found
    if trial.support > design.pilot_max_support and not sides_are_apart:
        return told
    return math.sqrt(min(told, trial.taken / design.pilot_share) * trial.taken)


def try_on_pieces(plan: FilterPlan, pieces: Pieces) -> Trial:
    """Take the passes of a filter on pieces of a cloud.

    Parameters
    ----------
    plan : FilterPlan
        Of the filter, for one noise and spacing.
    pieces : Pieces
        Of the cloud.

    Returns
    -------
    Trial
        The noise is that of the ways of the inner points along their normals: from the median of
        the differences between neighbours on the surface, which are free of most of the detail
        (Rice's estimator) and of outliers.
    """
    if not pieces.is_whole:
        plan = replace(plan, winding=None)
    start = moved = pieces.points
    fixed, left = np.zeros(len(start), np.bool_), np.zeros(len(start))
    for number in range(len(plan.passes)):
        neighborhoods = find_neighborhoods(moved, plan.passes[number])
        moved, _, _ = passes.take_pass(start, moved, neighborhoods, plan, number, fixed, None, left)
    neighborhoods = find_neighborhoods(moved, plan.passes[-1])
    axes = neighborhoods.normals[: moved.shape[1]]
    normals = np.stack([neighborhoods.in_order(axis) for axis in axes], axis=1)
    ways = np.einsum("ij,ij->i", start - moved, normals)
    inner = pieces.inner
    _, nearest = k_nearest(moved, moved[inner], 2)
    others = np.where(nearest[:, 0] == inner, nearest[:, 1], nearest[:, 0])
    agreement = np.sign(np.einsum("ij,ij->i", normals[inner], normals[others]))
    differences = np.abs(ways[inner] - agreement * ways[others])
    return Trial(float(np.median(differences)) / _MEDIAN_DIFFERENCE, plan.support)
