"""What a filter does to a cloud, chosen from the cloud: noise, spacing, widths."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.flatness import shows_surface
from pcsmooth.filters.neighborhoods import Width
from pcsmooth.filters.noise import LARGEST_SUPPORT, Noise, measure_noise
from pcsmooth.filters.surroundings import Surroundings, look_around
from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.parts.part import Parts

#: Points of the neighbourhoods without noise, by dimension: for passes and for the last step.
_PASS_COUNT = {2: 4.0, 3: 12.0}
_LAST_COUNT = {2: 32.0, 3: 128.0}

#: Thickness of the sheet of points, in units of the noise: in each pass, of which the later find
#: a thinner one, and in the last step.
_PASS_THICKNESS = (2.5, 2.0, 1.25)
_LAST_THICKNESS = 2.5

#: Largest radius: the wanted one of this share of the points, and a margin; but not so much that
#: more than so many points are that near to a point in the mean, which bounds the time.
_REACHED = 0.95
_MARGIN = 1.2
_MOST_WITHIN = 2000.0

#: Factor by which a radius is made smaller until that is so.
_SHRINKAGE = 0.9


@dataclass(frozen=True)
class FilterPlan:
    """What was found of a cloud, and how it is to be filtered.

    Attributes
    ----------
    noise : Noise
        Its noise, measured, or as it was told.
    has_surface : bool
        Whether a surface shows at any scale (see `shows_surface`), or the noise was told: points
        that fill a volume have none to be moved to.
    spacing : float
        Median spacing of the points as if on a square lattice, sqrt(area / number), L.
    density_variation : float
        Ratio of the local spacings at the 95th and the 5th percentile.
    passes : tuple of Width
        Neighbourhoods of the passes.
    last : Width
        Neighbourhoods of the last step.
    support : float
        Points of a neighbourhood of the first pass at the median.
    """

    noise: Noise
    has_surface: bool
    spacing: float
    density_variation: float
    passes: tuple[Width, ...]
    last: Width
    support: float

    @property
    def moves_points(self) -> bool:
        """Whether there is anything to filter: noise, and a surface to take it from."""
        return self.has_surface and self.noise.deviation > 0.0

    def scaled(self, factor: float) -> FilterPlan:
        """Return the same for a cloud times a factor."""
        return replace(
            self,
            noise=self.noise.scaled(factor),
            spacing=self.spacing * factor,
            passes=tuple(width.scaled(factor) for width in self.passes),
            last=self.last.scaled(factor),
        )


def plan_filter(parts: Parts, distinct: Distinct, noise: float | None = None) -> FilterPlan | None:
    """Look at up to 800 points of a cloud at its start and plan its filter.

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position.
    noise : float, optional
        Standard deviation of the noise, L; measured by default (see `measure_noise`). If it is
        told, there is taken to be a surface.

    Returns
    -------
    FilterPlan or None
        None if there are too few points to filter: fewer than a pass needs.
    """
    dimension = parts.dimension
    if distinct.count < _PASS_COUNT[dimension]:
        return None
    return plan_from(look_around(parts, distinct, LARGEST_SUPPORT[dimension]), noise)


def plan_from(around: Surroundings, noise: float | None) -> FilterPlan:
    """Plan the filter of a cloud from what is around some of its points.

    Parameters
    ----------
    around : Surroundings
        As `measure_noise` takes it.
    noise : float, optional
        Standard deviation of the noise, L; measured by default.

    Returns
    -------
    FilterPlan
    """
    n, distances, dimension = around.count, around.distances, around.positions.shape[2]
    found = measure_noise(around) if noise is None else Noise(noise, 0)

    def wanted(count: float, thickness: float) -> tuple[npt.NDArray[np.int64], Width]:
        thickness *= found.deviation
        ranks = _ranks(distances, count, thickness, dimension)
        radii = distances[np.arange(len(ranks)), ranks]
        max_radius = _MARGIN * float(np.quantile(radii, _REACHED))
        return ranks, Width(count, thickness, _bounded(max_radius, distances, n, dimension))

    chosen = [wanted(_PASS_COUNT[dimension], thickness) for thickness in _PASS_THICKNESS]
    ranks, _ = chosen[0]
    radii, sizes = distances[np.arange(len(ranks)), ranks], ranks + 1.0
    spacings = 2.0 * radii / sizes if dimension == 2 else radii * np.sqrt(np.pi / sizes)
    low, middle, high = np.quantile(spacings, (0.05, 0.5, 0.95))
    return FilterPlan(
        found,
        noise is not None or shows_surface(around),
        float(middle),
        float(high / low),
        tuple(width for _, width in chosen),
        wanted(_LAST_COUNT[dimension], _LAST_THICKNESS)[1],
        float(np.median(sizes)),
    )


def _ranks(
    distances: npt.NDArray[np.float64], count: float, thickness: float, dimension: int
) -> npt.NDArray[np.int64]:
    """Rank of the farthest point of each neighbourhood: see `Width`; the last if none is wide."""
    sizes = np.arange(1.0, distances.shape[1] + 1.0)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        covered = sizes * (1.0 - (thickness / distances) ** (dimension - 1))
    is_wide = covered >= count
    return np.asarray(np.where(is_wide.any(axis=1), is_wide.argmax(axis=1), distances.shape[1] - 1))


def _bounded(
    max_radius: float, distances: npt.NDArray[np.float64], n_points: int, dimension: int
) -> float:
    """Return the radius, or less where it would hold more points than `_MOST_WITHIN` in the mean.

    Beyond the farthest of the nearest points, numbers are taken to grow as in a solid.
    """
    known, farthest = distances.shape[1], distances[:, -1]
    while True:
        growth = np.minimum(max_radius / farthest, float(n_points))
        counted = np.count_nonzero(distances < max_radius, axis=1)
        within = np.where(growth > 1.0, known * growth**dimension, counted)
        if np.minimum(within, n_points).mean() <= _MOST_WITHIN:
            return max_radius
        max_radius *= _SHRINKAGE
