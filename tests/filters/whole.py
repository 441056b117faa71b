"""The filter of points in memory, in their order and unit."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oracles import Array
from pcsmooth.filters.design import DESIGN, FilterDesign
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.planning import plan_filter
from pcsmooth.filters.surface_filter import filter_points
from pcsmooth.flows.restraint import FREE, Restraint
from pcsmooth.neighbors.coincident import mark_distinct
from pcsmooth.neighbors.spacing import measure_spacing
from pcsmooth.neighbors.surroundings import Surroundings, look_around
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.progress import Callback, ignore


@dataclass(frozen=True, eq=False)
class Filtered:
    """Filtered points, which of them were outliers, what error is left, and what became of all."""

    points: Array
    outliers: npt.NDArray[np.bool_]
    left: Array | None
    state: CloudState


def surroundings_of(points: Array) -> Surroundings:
    """What is around some points, as far as noise and flatness are measured from it."""
    cloud = WholeCloud.as_it_is(points)
    return look_around(cloud, mark_distinct(cloud), "noise", 800, 1000, 400)


def plan_of(
    points: Array,
    noise: float | None = None,
    design: FilterDesign = DESIGN,
    *,
    closed: bool = False,
) -> FilterPlan | None:
    cloud = WholeCloud.as_it_is(points)
    return plan_filter(cloud, mark_distinct(cloud), noise, design, closed=closed)


def filter_whole(
    points: Array,
    plan: FilterPlan | None,
    fixed: npt.NDArray[np.bool_] | None = None,
    *,
    redistribute: bool = True,
    restraint: Restraint = FREE,
    callback: Callback = ignore,
) -> Filtered:
    quiet = WholeCloud.as_it_is(points, fixed)
    spacing = measure_spacing(quiet, mark_distinct(quiet))
    radius = 2.0 * spacing if spacing > 0.0 else 1.0
    cloud = replace(quiet, callback=callback)
    found = filter_points(cloud, plan, radius, restraint=restraint, redistribute=redistribute)
    n = len(points)
    left = None if found.left is None else found.left.read(0, n)
    return Filtered(found.state.points.read(0, n), found.outliers.read(0, n), left, found.state)
