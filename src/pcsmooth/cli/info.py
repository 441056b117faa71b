"""`pcsmooth info`: what files hold, and what denoising would choose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.batch import run_on_files
from pcsmooth.cli.messages import computing, filled_in_words
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
from pcsmooth.cli.progress_bar import ProgressBar
from pcsmooth.cli.tile_options import tile_options
from pcsmooth.files.notes import Say
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from pcsmooth.files.cloud_input import CloudInput
    from pcsmooth.files.tiling import Tiling
    from pcsmooth.filters.plan import FilterPlan
    from pcsmooth.progress import Callback

#: Stages of a description, at most.
_STAGES = 3

#: Counts of points that are not like the others, in this order.
_COUNTS = ("not_finite", "noise_class", "fixed")

#: Noise, in local spacings, below which a neighbourhood is as small as can be.
_LITTLE = 0.3


@click.command()
@inputs_argument
@reading_options
@noise_class_option
@threads_option
@tile_options
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
      pcsmooth info city.laz --tile 1000000 --workers 2
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
    tiling: Tiling,
    threads: int | None,
) -> dict[str, Any]:
    """Describe one cloud."""
    from pcsmooth.cli.files import source_of
    from pcsmooth.files.opening import open_input

    source = source_of(input_path, reading, keeps_noise=keeps_noise)
    with (
        open_input(source, tiling=tiling, threads=threads, checks_active=False, say=say) as cloud,
        ProgressBar(source.path, _STAGES, shows_bar) as bar,
        computing(source.path, say),
    ):
        return {"file": source.path, **describe(cloud, threads, bar.tell)}


def _show(facts: dict[str, Any]) -> None:
    """Print the facts for a person."""
    width = max(map(len, facts))
    for name, value in facts.items():
        click.echo(f"{name.replace('_', ' '):<{width}}  {printable(_readable(value))}")


def describe(source: CloudInput, threads: int | None, callback: Callback) -> dict[str, Any]:
    """Collect the facts about a cloud, ready for JSON."""
    from dataclasses import asdict

    from pcsmooth.errors import InvalidInputError, NoFinitePointError
    from pcsmooth.files.report import PlanFacts
    from pcsmooth.filters.plan import plan_filter
    from pcsmooth.formats import coordinate_columns
    from pcsmooth.kernels.threads import thread_limit
    from pcsmooth.measured import measure_cloud
    from pcsmooth.methods.estimate import Estimate
    from pcsmooth.neighbors.marked import count_marked

    template = source.template
    facts: dict[str, Any] = {
        "points": source.count,
        "dimension": source.dimension,
        "coordinates": coordinate_columns(template),
        "position_type": str(template.position_type),
        "columns": {name: str(column.dtype) for name, column in template.columns.items()},
        "comments": list(template.comments),
        "warnings": list(template.warnings),
    }
    with thread_limit(threads):
        try:
            parts = source.parts(Estimate(), callback=callback)
        except NoFinitePointError:
            counts = (source.count - source.noise_count, source.noise_count, 0)
            return facts | dict(zip(_COUNTS, counts, strict=True))
        measured = measure_cloud(parts)
        plan = plan_filter(parts, measured.distinct)
        n_fixed = count_marked(parts.fixed)
    unit = parts.unit
    not_finite = source.count - parts.count - source.noise_count
    facts |= dict(zip(_COUNTS, (not_finite, source.noise_count, n_fixed), strict=True))
    low, high = parts.box * unit + parts.origin
    facts["coincident"] = parts.count - measured.distinct.count
    facts["minimum"] = low.tolist()
    facts["maximum"] = high.tolist()
    facts["extent"] = (high - low).tolist()
    facts["mean_spacing"] = measured.spacing * unit
    try:
        facts["suggested_radius"] = measured.radius("auto") * unit
    except InvalidInputError:
        facts["suggested_radius"] = None  # a single place has no spacing
    plan = None if plan is None else plan.scaled(unit)
    facts |= asdict(PlanFacts.of(plan))
    facts["suggested_scheme"] = "filter"
    facts["why"] = _reasons(plan, source.dimension)
    if source.dimension == 3 and low[2] == high[2]:
        facts["hint"] = "the third coordinate is constant: --dim 2 treats it as a plane curve"
    return facts


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


def _readable(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name} ({kind})" for name, kind in value.items()) or "none"
    if isinstance(value, list):
        if value and isinstance(value[0], str):
            return "; ".join(value)
        return "  ".join(f"{number:.10g}" for number in value) or "none"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
