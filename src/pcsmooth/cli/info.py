"""`pcsmooth info`: what files hold, and what denoising would choose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.batch import run_on_files
from pcsmooth.cli.flow_options import plan_summary
from pcsmooth.cli.messages import Say, computing, filled_in_words
from pcsmooth.cli.options import (
    Files,
    Reading,
    inputs_argument,
    jobs_option,
    json_option,
    noise_class_option,
    reading_options,
    threads_option,
)
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from pcsmooth.cloud import PointCloud
    from pcsmooth.filters.plan import FilterPlan

#: Noise, in local spacings, below which a neighbourhood is as small as can be.
_LITTLE = 0.3


@click.command()
@inputs_argument
@reading_options
@noise_class_option
@threads_option
@jobs_option
@json_option
def info(names: tuple[str, ...], jobs: int, as_json: bool, **options: Any) -> None:
    """Describe each point cloud INPUT (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin).

    Counts, columns, extent, spacing, coincident points, rows that are not finite, the noise, and
    what `denoise` would choose and why. Lengths are in the unit of the file.

    \b
    Examples:
      pcsmooth info scan.ply
      pcsmooth info scan.ply --json | jq .noise
      pcsmooth info scans/ --json > scans.jsonl
    """
    from pcsmooth.cli.files import reading_of_all

    options["reading"] = reading_of_all(options["reading"], names)
    files = Files(names, None, None, "", skip_existing=False, jobs=jobs)
    run_on_files(
        info_of_file, files, options, quiet=False, verbose=False, as_json=as_json, show=_show
    )


def info_of_file(
    input_path: str,
    output_path: None,
    *,
    say: Say,
    shows_bar: bool,
    reading: Reading,
    keeps_noise: bool,
    threads: int | None,
) -> dict[str, Any]:
    """Describe one cloud."""
    from pcsmooth.cli.files import display_name, read_input

    name = display_name(input_path)
    cloud = read_input(input_path, reading, say, keeps_noise=keeps_noise)
    with computing(name, say):
        return {"file": name, **describe(cloud, threads)}


def _show(facts: dict[str, Any]) -> None:
    """Print the facts for a person."""
    width = max(map(len, facts))
    for name, value in facts.items():
        click.echo(f"{name.replace('_', ' '):<{width}}  {printable(_readable(value))}")


def describe(cloud: PointCloud, threads: int | None) -> dict[str, Any]:
    """Collect the facts about a cloud, ready for JSON."""
    import numpy as np

    from pcsmooth.cli.files import count_noise
    from pcsmooth.errors import InvalidInputError
    from pcsmooth.filters.plan import plan_filter
    from pcsmooth.formats import coordinate_columns
    from pcsmooth.kernels.threads import thread_limit
    from pcsmooth.measured import measure_cloud
    from pcsmooth.parts.whole_cloud import WholeCloud
    from pcsmooth.positions import usable_rows

    finite = usable_rows(cloud.active_points)
    points = cloud.points[finite]
    facts: dict[str, Any] = {
        "points": len(cloud),
        "dimension": cloud.dimension,
        "coordinates": coordinate_columns(cloud),
        "position_type": str(cloud.position_type),
        "columns": {name: str(column.dtype) for name, column in cloud.columns.items()},
        "comments": list(cloud.comments),
        "warnings": list(cloud.warnings),
        "not_finite": int((~finite).sum()) - count_noise(cloud),
        "noise_class": count_noise(cloud),
        "fixed": 0 if cloud.fixed_marks is None else int(cloud.fixed_marks.sum()),
    }
    if len(points) == 0:
        return facts
    low, high = points.min(axis=0), points.max(axis=0)
    with thread_limit(threads):
        parts = WholeCloud.of(cloud.points, finite)
        measured = measure_cloud(parts)
        plan = plan_filter(parts, measured.distinct)
    facts["coincident"] = parts.count - measured.distinct.count
    facts["minimum"] = low.tolist()
    facts["maximum"] = high.tolist()
    facts["extent"] = (high - low).tolist()
    facts["mean_spacing"] = measured.spacing * parts.unit
    try:
        facts["suggested_radius"] = measured.radius("auto") * parts.unit
    except InvalidInputError:
        facts["suggested_radius"] = None  # a single place has no spacing
    facts |= plan_summary(None if plan is None else plan.scaled(parts.unit))
    facts["suggested_scheme"] = "filter"
    facts["why"] = _reasons(plan, facts)
    if cloud.dimension == 3 and np.ptp(points[:, 2]) == 0.0:
        facts["hint"] = "the third coordinate is constant: --dim 2 treats it as a plane curve"
    return facts


def _reasons(plan: FilterPlan | None, facts: dict[str, Any]) -> str:
    """Say why the filter would do what it would do."""
    if plan is None or plan.noise.support == 0:
        return "too few points to measure noise: no point would move"
    if not plan.has_surface:
        return f"{filled_in_words(facts)}: no point would move"
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


def _readable(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name} ({kind})" for name, kind in value.items()) or "none"
    if isinstance(value, list):
        if value and isinstance(value[0], str):
            return "; ".join(value)
        return "  ".join(f"{number:.10g}" for number in value) or "none"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
