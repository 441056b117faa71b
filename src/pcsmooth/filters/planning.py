"""What a filter is to do to a cloud, chosen from the cloud: noise, spacing, widths."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.design import DESIGN, FilterDesign
from pcsmooth.filters.flatness import shows_surface
from pcsmooth.filters.neighborhoods import Width
from pcsmooth.filters.noise import Noise, measure_noise
from pcsmooth.filters.pilot import Trial, correct_noise, cut_pieces, try_on_pieces
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.scale_measuring import are_uneven, measure_scales
from pcsmooth.filters.scales import ScaleMap, lattice_spacing
from pcsmooth.filters.sides import Sides, look_at_sides
from pcsmooth.filters.steps import has_steps
from pcsmooth.filters.strays import has_crowd, leave_out_strays
from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.neighbors.surroundings import Surroundings, look_around
from pcsmooth.parts.part import Parts

#: Nearest points that are looked for, in units of those that a map is made from: so that which of
#: several equally far ones are among these is no matter of chance.
_BEYOND = 1.25

#: Cells along a cloud, of the least in which points look for their neighbours, at most.
_CELLS = 1 << 18


def plan_filter(
    parts: Parts,
    distinct: Distinct,
    noise: float | None = None,
    design: FilterDesign = DESIGN,
    *,
    closed: bool = False,
) -> FilterPlan | None:
    """Look at some points of a cloud at its start and plan its filter.

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position.
    noise : float, optional
        Standard deviation of the noise, L; measured by default (see `measure_noise`,
        `correct_noise`). If it is told, there is taken to be a surface.
    design : FilterDesign
        Numbers to go by.
    closed : bool
        Whether the surface is told to be closed: the sides of thin parts are then told apart (see
        `Sides`).

    Returns
    -------
    FilterPlan or None
        None if there are too few points to filter: fewer than a pass needs.
    """
    if distinct.count < design.pass_count[parts.dimension]:
        return None
    located = design.noise_supports[parts.dimension][-1]
    everywhere = look_around(parts, distinct, "noise", design.samples, design.nearest, located)
    is_crowded = has_crowd(everywhere, design)
    around = leave_out_strays(everywhere, design) if is_crowded else everywhere
    measured = measure_noise(around, design)
    scales = _scales_of(around, design)
    scale_map = None
    if scales is not None and has_steps(around, design):
        scale_map = scales
    elif scales is not None and are_uneven(scales.scales, parts.dimension, design):
        nearest = math.ceil(_BEYOND * design.map_nearest)
        closer = look_around(
            parts, distinct, "noise", design.map_samples, nearest, design.map_nearest
        )
        if is_crowded:
            closer = leave_out_strays(closer, design)
        scales = scale_map = measure_scales(closer, design)
    has_surface = noise is not None or shows_surface(around, design)
    extent = float(np.ptp(parts.box, axis=0).max())
    if noise is not None:
        found = Noise(noise, 0)
        if scale_map is not None:
            scale_map = scale_map.with_noise(noise)
    elif scales is None:
        found = measured
    else:
        # Groups of samples see less of the surface's detail than all neighbourhoods together.
        middle = float(np.median(scales.scales.noise))
        deviation = middle if scale_map is not None else min(middle, measured.deviation)
        found = replace(measured, deviation=deviation)

    stray_share = 1.0 - len(around.distances) / len(everywhere.distances)

    sides: Sides | None = None

    def plan_for(deviation: float, *, is_known: bool = True) -> FilterPlan:
        told = replace(found, deviation=deviation)
        plan = _planned(around, told, has_surface, scale_map, extent, design)
        winding = None if sides is None else sides.seen_through(deviation, is_known=is_known)
        return replace(plan, stray_share=stray_share, winding=winding, is_closed=closed)

    plan = plan_for(found.deviation)
    if closed and plan.moves_points:
        sides = look_at_sides(parts, distinct, is_crowded, design)
        plan = plan_for(found.deviation)
    is_known = noise is not None or scale_map is not None or not plan.moves_points
    # A crowd of outliers would be in the pieces, too.
    if is_known or is_crowded or distinct.count < design.pilot_least:
        return plan
    pieces = cut_pieces(parts, distinct, plan, design)

    def try_filter(told: float) -> Trial:
        return try_on_pieces(plan_for(told, is_known=False), pieces)

    are_apart = pieces.is_whole and plan_for(found.deviation, is_known=False).winding is not None
    corrected = correct_noise(found.deviation, try_filter, design, sides_are_apart=are_apart)
    return plan_for(corrected)


def _scales_of(around: Surroundings, design: FilterDesign) -> ScaleMap | None:
    """Measure how noise and spacing vary, if there are enough samples."""
    samples, _, dimension = around.positions.shape
    if samples < max(design.cover_group, design.noise_group[dimension]):
        return None
    return measure_scales(around, design)


def _planned(
    around: Surroundings,
    found: Noise,
    has_surface: bool,
    scale_map: ScaleMap | None,
    extent: float,
    design: FilterDesign,
) -> FilterPlan:
    """Choose the neighbourhoods for a noise that has been found; extent of the cloud, L."""
    n, distances, dimension = around.count, around.distances, around.positions.shape[2]

    def wanted(count: float, deviations: float) -> tuple[npt.NDArray[np.int64], Width]:
        thickness = deviations * found.deviation
        ranks = _ranks(distances, count, thickness, dimension)
        radii = distances[np.arange(len(ranks)), ranks]
        radius = design.radius_margin * float(np.quantile(radii, design.radius_quantile))
        max_radius = _bounded(radius, distances, n, dimension, design)
        width = Width(count, deviations, thickness, max_radius, design.radius_slack, max_radius)
        if scale_map is not None:
            smallest = width.radii(scale_map.scales.extreme(np.min), dimension).most[0]
            width = replace(width, cell_size=max(float(smallest), extent / _CELLS))
        return ranks, width

    count = design.pass_count[dimension]
    chosen = [wanted(count, thickness) for thickness in design.pass_thickness]
    ranks, _ = chosen[0]
    radii, sizes = distances[np.arange(len(ranks)), ranks], ranks + 1
    spacings = lattice_spacing(radii, sizes, dimension)
    low, middle, high = np.quantile(spacings, (0.05, 0.5, 0.95))
    return FilterPlan(
        found,
        has_surface,
        float(middle),
        float(high / low),
        tuple(width for _, width in chosen),
        wanted(design.last_count[dimension], design.last_thickness)[1],
        float(np.median(sizes)),
        design,
        scale_map,
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
    radius: float,
    distances: npt.NDArray[np.float64],
    n_points: int,
    dimension: int,
    design: FilterDesign,
) -> float:
    """Return the radius, or less where it would hold more points than it may in the mean.

    Beyond the farthest of the nearest points, numbers are taken to grow as in a solid.
    """
    known, farthest = distances.shape[1], distances[:, -1]
    while True:
        growth = np.minimum(radius / farthest, float(n_points))
        counted = np.count_nonzero(distances < radius, axis=1)
        within = np.where(growth > 1.0, known * growth**dimension, counted)
        if np.minimum(within, n_points).mean() <= design.max_within:
            return radius
        radius *= design.radius_shrinkage
