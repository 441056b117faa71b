"""What a cloud is like, and what denoising would choose for it and why."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from pcsmooth.errors import InvalidInputError, NoFinitePointError
from pcsmooth.files.cloud_input import CloudInput
from pcsmooth.files.report import (
    PlanFacts,
    PointFacts,
    Report,
    SelectionFacts,
    filled_in_words,
)
from pcsmooth.files.selection import Selection
from pcsmooth.files.taking_part import TakingPart
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.planning import plan_filter
from pcsmooth.formats import format_of_file, output_format
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.measured import SPARSE, measure_cloud
from pcsmooth.methods.estimate import Estimate
from pcsmooth.neighbors.marked import count_marked
from pcsmooth.neighbors.spacing_quantiles import spacing_quantiles
from pcsmooth.progress import Callback

#: Noise, in local spacings, below which a neighbourhood is as small as can be.
_LITTLE = 0.3

#: Variation of the spacing beyond which one radius is too large here or too small there.
_UNEVEN = 2.0


@dataclass(frozen=True)
class Findings:
    """What was measured of the points that take part.

    Attributes
    ----------
    coincident : int
        Points at the position of another one.
    minimum, maximum, extent : list of float
        Corners of the bounding box and their difference, L.
    mean_spacing : float
        L.
    local_spacing_p5, local_spacing_p50, local_spacing_p95 : float
        Percentiles of the spacing along the surface (see `local_spacings`), L.
    spacing_variation : float or None
        How many times the first of them the last one is.
    suggested_radius : float or None
        Of balls, L; None of a single place, which has no spacing.
    sparse_share : float
        Share of the surface for which it is too small, so that `denoise` and `curvature` take
        local radii if it is more than 0.09.
    plan : PlanFacts
        Noise and density.
    suggested_scheme, why : str
        What `denoise` would do, and the reason.
    """

    coincident: int
    minimum: list[float]
    maximum: list[float]
    extent: list[float]
    mean_spacing: float
    local_spacing_p5: float
    local_spacing_p50: float
    local_spacing_p95: float
    spacing_variation: float | None
    suggested_radius: float | None
    sparse_share: float
    plan: PlanFacts
    suggested_scheme: str
    why: str


@dataclass(frozen=True)
class CloudFacts(Report):
    """What a cloud is like.

    Attributes
    ----------
    file : str
        Where it comes from.
    format : str
        Its format, such as ``"ply"``, and how it is compressed, such as ``"ply, gzip"``.
    points, dimension : int
        How many, and of how many coordinates.
    coordinates : list of str
        Their columns.
    position_type : str
        Type of the coordinates.
    columns : dict of str to str
        All others, and their types: numpy's names of numbers, text, or list.
    comments, warnings : list of str
        Of the file, and of its reader.
    not_finite, noise_class, selection
        See `PointFacts`.
    fixed : int
        Points that stay.
    findings : Findings or None
        What was measured, if a point takes part.
    hint : str or None
        What may be better done another way.
    """

    file: str
    format: str
    points: int
    dimension: int
    coordinates: list[str]
    position_type: str
    columns: dict[str, str]
    comments: list[str]
    warnings: list[str]
    not_finite: int
    noise_class: int
    selection: SelectionFacts | None
    fixed: int
    findings: Findings | None = None
    hint: str | None = None


def describe_cloud(
    source: CloudInput,
    selection: Selection | None,
    threads: int | None,
    callback: Callback,
) -> CloudFacts:
    """Find out what a cloud is like.

    Parameters
    ----------
    source : CloudInput
        The cloud.
    selection : Selection or None
        Which points are looked at: its others are to be ignored.
    threads : int or None
        Threads to use.
    callback : callable
        Told how far it is.
    """
    with thread_limit(threads):
        try:
            parts = source.parts(Estimate(), TakingPart(source.name, None, selection), callback)
        except NoFinitePointError:
            missed = None
            if selection is not None and source.counts.ignored:
                missed = selection.missed_in_words(source.counts.box, source.counts.noise)
            return _facts(source, selection, 0, 0, hint=missed)
        measured = measure_cloud(parts)
        spacings = spacing_quantiles(parts, measured.distinct)
        sparse_share = measured.sparse_share(parts)
        plan = plan_filter(parts, measured.distinct)
        fixed = count_marked(parts.fixed)
    unit = parts.unit
    low, high = parts.box * unit + parts.origin
    try:
        radius = measured.radius("auto") * unit
    except InvalidInputError:
        radius = None
    plan = None if plan is None else plan.scaled(unit)
    findings = Findings(
        parts.count - measured.distinct.count,
        low.tolist(),
        high.tolist(),
        (high - low).tolist(),
        measured.spacing * unit,
        spacings.dense * unit,
        spacings.median * unit,
        spacings.sparse * unit,
        spacings.variation,
        radius,
        sparse_share,
        PlanFacts.of(plan),
        "filter",
        _reasons(plan, source.dimension),
    )
    hints = []
    if source.dimension == 3 and low[2] == high[2]:
        hints.append("the third coordinate is constant: --dim 2 treats it as a plane curve")
    if spacings.variation is not None and spacings.variation > _UNEVEN:
        remedy = (
            "--radius auto takes local radii"
            if sparse_share > SPARSE
            else "--radius local suits this cloud"
        )
        hints.append(
            f"points are {spacings.variation:.2g} times as far apart in some places as in "
            f"others: {remedy}"
        )
    return _facts(source, selection, parts.count, fixed, findings, "; ".join(hints) or None)


def _facts(
    source: CloudInput,
    selection: Selection | None,
    taking_part: int,
    fixed: int,
    findings: Findings | None = None,
    hint: str | None = None,
) -> CloudFacts:
    template = source.template
    points = PointFacts.of(template, source.count, taking_part, source.counts, selection)
    return CloudFacts(
        source.name,
        _format(source),
        points.points,
        points.dimension,
        points.coordinates,
        str(template.position_type),
        {name: _type(column.dtype) for name, column in template.columns.items()},
        list(template.comments),
        list(template.warnings),
        points.not_finite,
        points.noise_class,
        points.selection,
        fixed,
        findings,
        hint,
    )


def _format(source: CloudInput) -> str:
    """Say of what format a cloud is; of a stream, what it would be written as."""
    if os.path.isfile(source.name):
        return ", ".join(filter(None, format_of_file(source.name)))
    return output_format(None, source.template)


def _type(dtype: np.dtype[Any]) -> str:
    return {"U": "text", "O": "list"}.get(dtype.kind) or dtype.name


def _reasons(plan: FilterPlan | None, dimension: int) -> str:
    """Say why the filter would do what it would do."""
    if plan is None or plan.noise.support == 0:
        return "too few points to measure noise: no point would move"
    if not plan.has_surface:
        return f"{filled_in_words(dimension)}: no point would move"
    ratio = plan.noise.deviation / plan.spacing if plan.spacing > 0.0 else 0.0
    if ratio == 0.0:
        return "no noise was found: no point would move"
    needs = (
        "as wide as noise thicker than the spacing needs"
        if ratio > 1.0
        else "wide enough for the noise"
        if ratio > _LITTLE
        else "as small as little noise allows"
    )
    return (
        f"noise measured in neighbourhoods of {plan.noise.support} points is {ratio:.2g} local "
        f"spacings: the filter takes {plan.support:.0f} points, {needs}"
    )
